// The reports of the C interface and their messages.
#pragma once

#include <cageform/c/detail/objects.hpp>

#include <cstdio>

namespace cageform::inline CAGEFORM_ABI::detail::c {

constexpr const char* word_of(std::uint32_t element) noexcept {
    switch (element) {
    case CAGEFORM_VERTEX: return "vertex";
    case CAGEFORM_EDGE: return "edge";
    case CAGEFORM_FACE: return "face";
    case CAGEFORM_LOOP: return "loop";
    default: return "";
    }
}
/// Returns an empty report.
inline cageform_report empty_report() noexcept {
    cageform_report report{};
    report.culprit = report.frame = CAGEFORM_NONE;
    report.fault.a = report.fault.b = CAGEFORM_NONE;
    report.fault.text = "";
    return report;
}

/// Writes the message of a report: the status text, and the culprit with `word` (its kind) and frame.
inline void add_message(cageform_report& report, const char* word) noexcept {
    char* const at = report.message;
    constexpr std::size_t room = sizeof(report.message);
    const char* const text = cageform_status_text(report.status);
    const auto& fault = report.fault;
    if (report.status == CAGEFORM_OK) {
        at[0] = 0;
    } else if (report.faults > 0 && fault.status == report.status && fault.a_is != CAGEFORM_NO_ELEMENT) {
        if (fault.b_is != CAGEFORM_NO_ELEMENT)
            std::snprintf(at, room, "%s (%s %zu, %s %zu)", text, word_of(fault.a_is), fault.a,
                          word_of(fault.b_is), fault.b);
        else
            std::snprintf(at, room, "%s (%s %zu)", text, word_of(fault.a_is), fault.a);
    } else if (report.culprit != CAGEFORM_NONE && report.frame != CAGEFORM_NONE) {
        std::snprintf(at, room, "%s (frame %zu, %s %zu)", text, report.frame, word, report.culprit);
    } else if (report.culprit != CAGEFORM_NONE) {
        std::snprintf(at, room, "%s (%s %zu)", text, word, report.culprit);
    } else {
        std::snprintf(at, room, "%s", text);
    }
}
inline void add_message(cageform_report& report) noexcept {
    add_message(report, "number");
}

/// Runs f(report), which returns a status code. Copies the report to the caller's and returns the code.
///
///   word  the kind of the culprit; read after f, which may change it
template <class F>
cageform_status reported(cageform_report* out, const char* const& word, const F& f) noexcept {
    if (out != nullptr && out->size < sizeof(out->size)) return CAGEFORM_SIZE_NOT_SET;
    cageform_report report = empty_report();
    report.status = guarded([&] { return f(report); });
    add_message(report, word);
    return out == nullptr ? report.status : (static_cast<void>(write_struct(report, out)), report.status);
}

} // namespace cageform::inline CAGEFORM_ABI::detail::c
