// The parallel loop, threads and progress callback of the caller.
#pragma once

#include <cageform/c/detail/objects.hpp>

#if !defined(CAGEFORM_C_RUNTIME_ONLY)
#include <cageform/parallel/running.hpp>

#include <atomic>
#include <exception>
#endif

// mingw-w64 without posix threads and WebAssembly have no threads: cageform_running::threads is ignored.
#if !defined(CAGEFORM_C_RUNTIME_ONLY) && !defined(__wasi__) &&                                               \
    (!defined(__GLIBCXX__) || defined(_GLIBCXX_HAS_GTHREADS))
#define CAGEFORM_DETAIL_C_THREADS
#include <cageform/parallel/threads.hpp>
#endif

namespace cageform::inline CAGEFORM_ABI::detail::c {

/// The caller's loop, without allocation. Serial, threaded and user loops share this type, so that a
/// clone is compiled once.
struct CallersFor {
    const cageform_running& running;

    template <class Body>
    void operator()(std::size_t count, std::size_t grain, Body&& body) const {
        if (running.parallel_for != nullptr || is_threaded()) {
            struct Call {
                std::remove_reference_t<Body>& body;
                std::size_t count;
            } call{body, count};
            run(count, grain, &call, [](void* argument, std::size_t begin, std::size_t end) {
                auto& its = *static_cast<Call*>(argument);
                if (begin < end && end <= its.count) its.body(begin, end);
            });
        } else if (count > 0) {
            body(std::size_t{0}, count);
        }
    }

private:
    bool is_threaded() const noexcept {
#if defined(CAGEFORM_DETAIL_C_THREADS)
        return running.threads > 1;
#else
        return false;
#endif
    }
    void run(std::size_t count, std::size_t grain, void* call,
             void (*body)(void*, std::size_t, std::size_t)) const {
        if (running.parallel_for != nullptr)
            return running.parallel_for(running.context, count, grain, body, call);
#if defined(CAGEFORM_DETAIL_C_THREADS)
        ThreadedFor{running.threads}(count, grain,
                                     [&](std::size_t begin, std::size_t end) { body(call, begin, end); });
#endif
    }
};

#if !defined(CAGEFORM_C_RUNTIME_ONLY)
/// Calls use(running) with the caller's threads and progress. Exceptions cannot pass through C
/// functions: an exception of a body in the caller's loop is rethrown here.
template <class Use>
cageform_status with_running(const cageform_running* given, const Use& use) {
    cageform_running own;
    if (const cageform_status status = read_struct(given, own); status != CAGEFORM_OK) return status;
    Running running;
    if (own.parallel_for != nullptr) {
        running.parallel = [own](std::size_t count, std::size_t grain, const RangeBody& body) {
#if defined(__cpp_exceptions)
            std::atomic<bool> has_thrown = false;
            std::exception_ptr thrown;
            CallersFor{own}(count, grain, [&](std::size_t begin, std::size_t end) {
                try {
                    body(begin, end);
                } catch (...) {
                    if (!has_thrown.exchange(true)) thrown = std::current_exception();
                }
            });
            if (thrown) std::rethrow_exception(thrown);
#else
            CallersFor{own}(count, grain, body);
#endif
        };
    }
#if defined(CAGEFORM_DETAIL_C_THREADS)
    else if (own.threads > 1)
        running.parallel = ThreadedFor{own.threads};
#endif
    if (own.progress != nullptr)
        running.progress = [own](double done) { return own.progress(own.context, done) != 0; };
    return use(running);
}
#endif

} // namespace cageform::inline CAGEFORM_ABI::detail::c
