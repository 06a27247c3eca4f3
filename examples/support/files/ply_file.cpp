#include "files/ply_file.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

namespace cageform_support {

namespace {

constexpr std::size_t longest_ply_line = std::size_t{1} << 24; // bytes
constexpr std::size_t most_properties = 4096;

bool is_swapped(PlyEncoding encoding) {
    return (encoding == PlyEncoding::big_endian) == (std::endian::native == std::endian::little);
}

template <class X>
double number_as(const char* bytes, bool swapped) {
    std::array<char, sizeof(X)> of_number;
    std::copy_n(bytes, sizeof(X), of_number.begin());
    if (swapped) std::reverse(of_number.begin(), of_number.end());
    return double(std::bit_cast<X>(of_number));
}

/// Calls f with a value of a type.
template <class F>
auto with_type(PlyType type, const F& f) {
    switch (type) {
    case PlyType::int8: return f(std::int8_t{});
    case PlyType::uint8: return f(std::uint8_t{});
    case PlyType::int16: return f(std::int16_t{});
    case PlyType::uint16: return f(std::uint16_t{});
    case PlyType::int32: return f(std::int32_t{});
    case PlyType::uint32: return f(std::uint32_t{});
    case PlyType::float32: return f(float{});
    case PlyType::float64: break;
    }
    return f(double{});
}

template <class X>
void append_as(std::string& bytes, double number) {
    X value{};
    if constexpr (std::is_integral_v<X>) {
        using Limits = std::numeric_limits<X>;
        if (number == number) value = X(std::clamp(number, double(Limits::min()), double(Limits::max())));
    } else {
        value = X(number);
    }
    auto of_number = std::bit_cast<std::array<char, sizeof(X)>>(value);
    if (std::endian::native == std::endian::big) std::reverse(of_number.begin(), of_number.end());
    bytes.append(of_number.data(), of_number.size());
}

/// Old and new names, in the order of PlyType.
constexpr std::array<std::array<std::string_view, 2>, 8> type_names{{{"char", "int8"},
                                                                     {"uchar", "uint8"},
                                                                     {"short", "int16"},
                                                                     {"ushort", "uint16"},
                                                                     {"int", "int32"},
                                                                     {"uint", "uint32"},
                                                                     {"float", "float32"},
                                                                     {"double", "float64"}}};

/// Parses a line "property". Returns the error; empty on success.
std::string parse_property(std::string_view line, const std::vector<std::string_view>& words,
                           std::vector<PlyElement>& elements) {
    const bool is_list = words.size() == 5 && words[1] == "list";
    if (elements.empty() || (!is_list && words.size() != 3))
        return '"' + std::string(line) + "\" does not declare a property of an element";
    const auto type = ply_type(words[words.size() - 2]), count = is_list ? ply_type(words[2]) : std::nullopt;
    if (!type || (is_list && (!count || *count >= PlyType::float32)))
        return '"' + std::string(line) + "\" has a type that PLY files do not have";
    PlyElement& element = elements.back();
    if (element.find(words.back()))
        return "the element " + element.name + " has the property " + std::string(words.back()) + " twice";
    if (element.properties.size() == most_properties)
        return "the element " + element.name + " has more than " + std::to_string(most_properties) +
               " properties";
    element.properties.push_back({std::string(words.back()), *type, count});
    return {};
}

void append_to(std::vector<double>& numbers, const PlacedNumber& number) {
    numbers.push_back(number.value);
}
void append_to(std::vector<PlacedNumber>& numbers, const PlacedNumber& number) {
    numbers.push_back(number);
}

} // namespace

std::vector<std::string_view> ply_words(std::string_view line) {
    constexpr std::string_view blanks = " \t\r\f\v";
    std::vector<std::string_view> words;
    for (std::size_t from = line.find_first_not_of(blanks); from != std::string_view::npos;) {
        const std::size_t to = std::min(line.find_first_of(blanks, from), line.size());
        words.push_back(line.substr(from, to - from));
        from = line.find_first_not_of(blanks, to);
    }
    return words;
}

std::optional<PlyType> ply_type(std::string_view word) {
    for (std::size_t n = 0; n < type_names.size(); ++n) {
        if (word == type_names[n][0] || word == type_names[n][1]) return PlyType(n);
    }
    return std::nullopt;
}

std::string_view name_of(PlyType type) {
    return type_names[std::size_t(type)][0];
}

double number_at(std::string_view bytes, std::size_t position, PlyType type, PlyEncoding encoding) {
    return with_type(type, [&](auto number) {
        return number_as<decltype(number)>(bytes.data() + position, is_swapped(encoding));
    });
}

void append_number(std::string& bytes, PlyType type, double number) {
    with_type(type, [&](auto as) { append_as<decltype(as)>(bytes, number); });
}

ReplacedNumbers::ReplacedNumbers(std::string_view bytes, PlyEncoding encoding)
    : bytes_(bytes)
    , encoding_(encoding) {
    result_.reserve(bytes.size() + (encoding == PlyEncoding::ascii ? bytes.size() / 2 : 0));
}

void ReplacedNumbers::keep_to(std::size_t position) {
    result_.append(bytes_.substr(copied_, position - copied_));
}

std::string ReplacedNumbers::replace(const PlacedNumber& number, PlyType type, double now) {
    if (now == number.value) return {};
    if (type < PlyType::float32)
        return "has the type " + std::string(name_of(type)) + ", which cannot store its moved value";
    const bool is_single = type == PlyType::float32;
    if (!std::isfinite(is_single ? double(float(now)) : now))
        return "exceeds the range of its type after the move";
    if (is_single && float(now) == float(number.value)) return {};
    keep_to(number.begin);
    copied_ = number.end;
    if (encoding_ == PlyEncoding::ascii) {
        is_single ? detail::append_digits(result_, float(now)) : detail::append_digits(result_, now);
        return {};
    }
    append_number(result_, type, now);
    if (encoding_ == PlyEncoding::big_endian)
        std::reverse(result_.end() - std::ptrdiff_t(bytes_of(type)), result_.end());
    return {};
}

void ReplacedNumbers::replace(const PlacedNumber& number, const PlacedNumber& by) {
    keep_to(number.begin);
    result_.append(bytes_.substr(by.begin, by.end - by.begin));
    copied_ = number.end;
}

std::string ReplacedNumbers::finish() && {
    keep_to(bytes_.size());
    return std::move(result_);
}

std::size_t bytes_of(PlyType type) {
    constexpr std::array<std::size_t, 8> bytes{1, 1, 2, 2, 4, 4, 4, 8};
    return bytes[std::size_t(type)];
}

std::optional<std::size_t> PlyElement::find(std::string_view property) const {
    for (std::size_t n = 0; n < properties.size(); ++n) {
        if (properties[n].name == property) return n;
    }
    return std::nullopt;
}

std::optional<std::size_t> PlyElement::record_bytes() const {
    std::size_t bytes = 0;
    for (const PlyProperty& property : properties) {
        if (property.count) return std::nullopt;
        bytes += bytes_of(property.type);
    }
    return bytes;
}

bool is_end_of_ply_header(std::string_view line) {
    const auto words = ply_words(line);
    return !words.empty() && words[0] == "end_header";
}

std::string parse_ply_line(std::string_view line, PlyHeader& header) {
    const auto words = ply_words(line);
    if (words.empty()) return {};
    if (words[0] == "property") return parse_property(line, words, header.elements);
    if (words[0] == "comment" || words[0] == "obj_info") {
        const std::size_t begin = line.find(words[0]) + words[0].size();
        header.comments.emplace_back(detail::trim(line.substr(begin)));
    } else if (words[0] == "format") {
        constexpr std::array<std::string_view, 3> names{"ascii", "binary_little_endian", "binary_big_endian"};
        const auto name = std::find(names.begin(), names.end(), words.size() > 1 ? words[1] : "");
        if (name == names.end())
            return "the format is none of ascii, binary_little_endian, binary_big_endian";
        if (words.size() > 2 && words[2] != "1.0")
            return "the version of the format is " + detail::quoted(words[2]) + "; version 1.0 is read";
        header.encoding = PlyEncoding(name - names.begin());
    } else if (words[0] == "element") {
        PlyElement element;
        const std::string_view count = words.size() == 3 ? words[2] : std::string_view();
        if (!detail::parse_whole(count, element.count) || header.find(words[1]) != nullptr ||
            element.count > std::uint64_t{1} << 48)
            return '"' + std::string(line) + "\" does not declare a new element and its number of records";
        element.name = words[1];
        header.elements.push_back(std::move(element));
    } else {
        return '"' + std::string(words[0].substr(0, 40)) + "\" is not a keyword of a PLY file's header";
    }
    return {};
}

const PlyElement* PlyHeader::find(std::string_view element) const {
    for (const PlyElement& each : elements) {
        if (each.name == element) return &each;
    }
    return nullptr;
}

PlyReader::PlyReader(const std::string& path)
    : path_(path)
    , file_(path) {
    start();
}

PlyReader::PlyReader(std::string_view bytes, std::string name)
    : path_(std::move(name))
    , text_(bytes) {
    start();
}

void PlyReader::start() {
    (void)read_header();
    std::size_t most = 0;
    for (const PlyElement& element : header_.elements) most = std::max(most, element.properties.size());
    of_record_.resize(most);
}

bool PlyReader::fail(const std::string& why) {
    if (error_.empty()) error_ = file_ && !file_->error().empty() ? file_->error() : path_ + ": " + why;
    return false;
}

bool PlyReader::fill(std::size_t bytes) {
    if (text_.size() - at_ >= bytes) return true;
    if (!file_) return false;
    buffer_.erase(0, at_);
    at_ = 0;
    bool is_more = true;
    while (is_more && buffer_.size() < bytes) is_more = file_->read(buffer_);
    text_ = buffer_;
    return is_more;
}

std::optional<std::string_view> PlyReader::take_line() {
    std::size_t end = std::string::npos;
    for (std::size_t searched = 0; end == std::string::npos;) {
        end = text_.find(line_end_, at_ + searched);
        if (end != std::string::npos) break;
        searched = text_.size() - at_;
        if (searched > longest_ply_line) return std::nullopt;
        if (fill(searched + 1)) continue;
        if (searched == 0 || (file_ && !file_->error().empty())) return std::nullopt;
        end = text_.size(); // the last line has no line break
    }
    std::string_view line = text_.substr(at_, end - at_);
    at_ = std::min(end + 1, text_.size());
    ++line_;
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
}

bool PlyReader::read_header() {
    if (!fill(4) || !(text_.starts_with("ply\n") || text_.starts_with("ply\r")))
        return fail("is no PLY file: it does not begin with \"ply\"");
    if (text_[3] == '\r' && fill(5) && text_[4] != '\n' && text_[4] != '\r') line_end_ = '\r';
    (void)take_line();
    while (const auto line = take_line()) {
        if (is_end_of_ply_header(*line))
            return header_.encoding ? true : fail("its header has no line \"format\"");
        if (const std::string why = parse_ply_line(*line, header_); !why.empty())
            return fail("line " + std::to_string(line_) + ": " + why);
    }
    return fail("its header has no line \"end_header\"");
}

std::string PlyReader::place() const {
    return header_.elements[element_].name + " " + std::to_string(position_);
}

/// Whether the file is large enough for all records of an element, if known.
bool PlyReader::fits(const PlyElement& element) const {
    const auto bytes = element.record_bytes();
    if (!bytes || header_.encoding == PlyEncoding::ascii || *bytes == 0) return true;
    std::uintmax_t left = text_.size() - at_;
    if (file_ && file_->size() == 0) return true; // a pipe
    if (file_) left += file_->size() - std::min(file_->size(), file_->bytes_read());
    return element.count <= left / *bytes;
}

bool PlyReader::begin(std::string_view name, const std::vector<std::string>& properties) {
    if (!error_.empty()) return false;
    const PlyElement* const element = header_.find(name);
    if (element == nullptr) return fail("has no element " + std::string(name));
    const auto number = std::size_t(element - header_.elements.data());
    if (number < element_ || (number == element_ && position_ > 0))
        return fail("the element " + std::string(name) + " has been read");
    std::vector<std::size_t> chosen;
    for (const std::string& property : properties) {
        const auto found = element->find(property);
        if (!found) return fail("its element " + std::string(name) + " has no property " + property);
        chosen.push_back(*found);
    }
    chosen_.clear();
    while (element_ < number) {
        if (!skip(header_.elements[element_].count - position_)) return false;
        ++element_;
        position_ = 0;
    }
    chosen_ = std::move(chosen);
    offsets_.clear();
    for (const std::size_t p : chosen_) {
        std::size_t offset = 0;
        for (std::size_t q = 0; q < p; ++q) offset += bytes_of(element->properties[q].type);
        offsets_.push_back(offset);
    }
    if (!fits(*element))
        return fail("is cut off: it is too short for the " + std::to_string(element->count) +
                    " records of its element " + element->name);
    return true;
}

bool PlyReader::skip(std::uint64_t records) {
    const bool is_empty = header_.elements[element_].properties.empty();
    if (is_empty && header_.encoding != PlyEncoding::ascii) return true;
    for (; records > 0; --records) {
        if (!read_record<double>(nullptr)) return false;
    }
    return true;
}

std::optional<std::uint64_t> PlyReader::hash_to_end() {
    const auto hash = file_ ? file_->hash_to_end() : std::nullopt;
    if (!hash) (void)fail({});
    return hash;
}

std::size_t PlyReader::read(std::size_t most, std::vector<double>& numbers) {
    return read_records(most, numbers);
}

std::size_t PlyReader::read(std::size_t most, std::vector<PlacedNumber>& numbers) {
    return read_records(most, numbers);
}

template <class Number>
std::size_t PlyReader::read_records(std::size_t most, std::vector<Number>& numbers) {
    if (!error_.empty() || element_ == header_.elements.size()) return 0;
    const PlyElement& element = header_.elements[element_];
    const auto count = std::size_t(std::min<std::uint64_t>(most, element.count - position_));
    const std::size_t before = numbers.size();
    for (std::size_t n = 0; n < count; ++n) {
        if (read_record(&numbers)) continue;
        numbers.resize(before);
        return 0;
    }
    return count;
}

template <class Number>
bool PlyReader::read_record(std::vector<Number>* numbers) {
    const bool read = header_.encoding == PlyEncoding::ascii ? read_line(numbers) : read_binary(numbers);
    position_ += read ? 1 : 0;
    return read;
}

bool PlyReader::take_number(PlyType type, PlacedNumber& number) {
    const std::size_t bytes = bytes_of(type);
    if (!fill(bytes)) return fail("is cut off in " + place());
    number = {number_at(text_, at_, type, *header_.encoding), at_, at_ + bytes};
    at_ += bytes;
    return true;
}

/// Appends the selected numbers of the record.
template <class Number>
void PlyReader::give(std::vector<Number>* numbers) const {
    for (std::size_t k = 0; numbers != nullptr && k < chosen_.size(); ++k) {
        for (const PlacedNumber& number : of_record_[chosen_[k]]) append_to(*numbers, number);
    }
}

template <class Number>
bool PlyReader::read_binary(std::vector<Number>* numbers) {
    const auto& properties = header_.elements[element_].properties;
    if (const auto bytes = header_.elements[element_].record_bytes()) {
        if (!fill(*bytes)) return fail("is cut off in " + place());
        for (std::size_t k = 0; numbers != nullptr && k < chosen_.size(); ++k) {
            const PlyType type = properties[chosen_[k]].type;
            const std::size_t from = at_ + offsets_[k];
            append_to(*numbers,
                      {number_at(text_, from, type, *header_.encoding), from, from + bytes_of(type)});
        }
        at_ += *bytes;
        return true;
    }
    for (std::size_t p = 0; p < properties.size(); ++p) {
        of_record_[p].clear();
        PlacedNumber number{1};
        if (properties[p].count) {
            if (!take_number(*properties[p].count, number)) return false;
            if (number.value < 0)
                return fail(place() + ": the list " + properties[p].name + " has a negative length");
            of_record_[p].push_back(number);
        }
        for (auto n = std::uint64_t(number.value); n > 0; --n) {
            if (!take_number(properties[p].type, number)) return false;
            of_record_[p].push_back(number);
        }
    }
    give(numbers);
    return true;
}

template <class Number>
bool PlyReader::read_line(std::vector<Number>* numbers) {
    std::vector<std::string_view> words;
    while (words.empty()) {
        const auto line = take_line();
        if (!line) return fail("is cut off in " + place());
        words = ply_words(*line);
    }
    const auto& properties = header_.elements[element_].properties;
    std::size_t next = 0;
    const auto take = [&](PlacedNumber& number) {
        if (next == words.size())
            return fail("line " + std::to_string(line_) + ": too few numbers for " + place());
        number.begin = std::size_t(words[next].data() - text_.data());
        number.end = number.begin + words[next].size();
        const std::string why = detail::parse_number(words[next++], number.value);
        return why.empty() || fail("line " + std::to_string(line_) + ": " + why);
    };
    for (std::size_t p = 0; p < properties.size(); ++p) {
        of_record_[p].clear();
        PlacedNumber number{1};
        if (properties[p].count) {
            if (!take(number)) return false;
            if (!(number.value >= 0 && number.value <= double(words.size())))
                return fail("line " + std::to_string(line_) + ": the list " + properties[p].name +
                            " is longer than its line");
            of_record_[p].push_back(number);
        }
        for (auto n = std::uint64_t(number.value); n > 0; --n) {
            if (!take(number)) return false;
            of_record_[p].push_back(number);
        }
    }
    if (next != words.size())
        return fail("line " + std::to_string(line_) + ": too many numbers for " + place());
    give(numbers);
    return true;
}

std::optional<std::string> little_endian_bytes(PlyReader& reader, const std::vector<PlyElement>& elements) {
    std::string bytes = "ply\nformat binary_little_endian 1.0\n";
    for (const std::string& comment : reader.header().comments) bytes += "comment " + comment + '\n';
    for (const PlyElement& element : elements) {
        bytes += "element " + element.name + ' ' + std::to_string(element.count) + '\n';
        for (const PlyProperty& property : element.properties) {
            bytes += "property ";
            if (property.count) bytes += std::string("list ") + std::string(name_of(*property.count)) + ' ';
            bytes += std::string(name_of(property.type)) + ' ' + property.name + '\n';
        }
    }
    bytes += "end_header\n";
    for (const PlyElement& element : elements) {
        std::vector<std::string> names;
        for (const PlyProperty& property : element.properties) names.push_back(property.name);
        if (!reader.begin(element.name, names)) return std::nullopt;
        std::vector<double> numbers;
        while (reader.read(1, numbers) > 0) {
            std::size_t next = 0;
            for (const PlyProperty& property : element.properties) {
                std::size_t count = 1;
                if (property.count) {
                    count = std::size_t(numbers[next]);
                    append_number(bytes, *property.count, numbers[next++]);
                }
                for (; count > 0; --count) append_number(bytes, property.type, numbers[next++]);
            }
            numbers.clear();
        }
        if (!reader.error().empty()) return std::nullopt;
    }
    return bytes;
}

} // namespace cageform_support
