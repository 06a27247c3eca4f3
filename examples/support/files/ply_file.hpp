#pragma once

// Reads PLY files of any size in blocks of records: ASCII, and binary of both byte orders.

#include "io/csv.hpp"
#include "io/input_file.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace cageform_support {

/// Help text on PLY files.
inline constexpr const char* ply_format =
    "PLY files are ASCII or binary, of either byte order. The numbers of an element can be\n"
    "of any type; elements, properties and lists that a program does not need are skipped.\n";

enum class PlyEncoding : std::uint8_t { ascii, little_endian, big_endian };
enum class PlyType : std::uint8_t { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

/// The type with an old or new name, such as uchar and uint8; nothing for other words.
std::optional<PlyType> ply_type(std::string_view name);

/// The old name, which all readers support.
std::string_view name_of(PlyType type);

/// Size of a number in bytes.
std::size_t bytes_of(PlyType type);

/// The number at a position of a binary file, which has bytes_of(type) bytes there.
double number_at(std::string_view bytes, std::size_t position, PlyType type, PlyEncoding encoding);

/// Appends a number in little-endian order. Out of range numbers are clamped; NaN becomes 0 in integer types.
void append_number(std::string& bytes, PlyType type, double number);

/// Copies the bytes of a file, with some numbers replaced. Replacements are in the order of the file.
class ReplacedNumbers {
public:
    /// The bytes must outlive this object.
    ReplacedNumbers(std::string_view bytes, PlyEncoding encoding);

    /// Replaces a number of a type. A number that is equal in its type keeps its bytes. In ASCII, it gets the
    /// fewest digits that restore it in its type. Returns the error if the type cannot store it; else empty.
    std::string replace(const PlacedNumber& number, PlyType type, double now);
    /// Replaces the bytes of a number by those of another.
    void replace(const PlacedNumber& number, const PlacedNumber& by);

    std::string finish() &&; ///< all bytes

private:
    void keep_to(std::size_t position);

    std::string_view bytes_;
    PlyEncoding encoding_;
    std::string result_;
    std::size_t copied_ = 0;
};

/// Splits a line at white space.
std::vector<std::string_view> ply_words(std::string_view line);

struct PlyProperty {
    std::string name;
    PlyType type = PlyType::float32;
    std::optional<PlyType> count; ///< type of the length of a list; none for single numbers
};

struct PlyElement {
    std::string name;
    std::uint64_t count = 0;
    std::vector<PlyProperty> properties;

    std::optional<std::size_t> find(std::string_view property) const; ///< index of a property
    std::optional<std::size_t> record_bytes() const;                  ///< in a binary file; none with lists
};

struct PlyHeader {
    std::optional<PlyEncoding> encoding; ///< none before the line "format"
    std::vector<std::string> comments;   ///< also of "obj_info" lines, without the first word
    std::vector<PlyElement> elements;

    const PlyElement* find(std::string_view element) const; ///< null if there is none
};

/// Parses a line of a header after the first, "ply". Returns the error; empty on success.
std::string parse_ply_line(std::string_view line, PlyHeader& header);

bool is_end_of_ply_header(std::string_view line);

/// Sequential reader of a PLY file. Memory: one block.
class PlyReader {
public:
    /// Reads the header; error() is set if the file cannot be read or is not PLY.
    explicit PlyReader(const std::string& path);
    /// Reads the header of a file in memory, which must outlive this object.
    ///
    ///   name   prefix of every message
    PlyReader(std::string_view bytes, std::string name);

    const PlyHeader& header() const { return header_; }
    const std::string& error() const { return error_; }            ///< the first error; empty if none
    bool may_retry() const { return file_ && file_->may_retry(); } ///< InputFile::may_retry
    /// InputFile::hash_to_end of a reader of a path; nothing can be read after it.
    std::optional<std::uint64_t> hash_to_end();

    /// Skips to the records of an element and selects the properties that read() returns. Fails if there is
    /// no such element or property, if a later element has been read, or the file is too short for the
    /// records.
    bool begin(std::string_view element, const std::vector<std::string>& properties);

    /// Appends the selected numbers of up to `most` records, in the order of the selection; a list as its
    /// length and its numbers. Returns the number of records; 0 at the end and after a failure (the file ends
    /// too early, or a word is not a number).
    std::size_t read(std::size_t most, std::vector<double>& numbers);
    /// As read(), with the position of each number in a file in memory.
    std::size_t read(std::size_t most, std::vector<PlacedNumber>& numbers);

    /// Index of the next record of the element.
    std::uint64_t position() const { return position_; }

private:
    bool fail(const std::string& why);
    bool fill(std::size_t bytes); // reads until the buffer has `bytes`; false on failure
    std::optional<std::string_view> take_line();
    void start();
    bool read_header();
    bool skip(std::uint64_t records);
    template <class Number>
    std::size_t read_records(std::size_t most, std::vector<Number>& numbers);
    template <class Number>
    bool read_record(std::vector<Number>* numbers);
    template <class Number>
    bool read_binary(std::vector<Number>* numbers);
    template <class Number>
    bool read_line(std::vector<Number>* numbers);
    template <class Number>
    void give(std::vector<Number>* numbers) const;
    bool take_number(PlyType type, PlacedNumber& number);
    std::string place() const;
    bool fits(const PlyElement& element) const;

    std::string path_, error_;
    std::optional<InputFile> file_; // none in memory
    PlyHeader header_;
    std::string buffer_;    // a part of the file
    std::string_view text_; // the buffer, or all bytes of a file in memory
    std::size_t at_ = 0;    // in the text
    std::uint64_t line_ = 0;
    char line_end_ = '\n';
    std::size_t element_ = 0;                          // index of the current element
    std::uint64_t position_ = 0;                       // next record of it
    std::vector<std::size_t> chosen_;                  // selected properties, in the order of the caller
    std::vector<std::size_t> offsets_;                 // of selected properties in a record without lists
    std::vector<std::vector<PlacedNumber>> of_record_; // by property
};

/// Converts a file, of which only the header has been read, to binary little-endian; nothing if the reader
/// fails.
///
///   elements   those of the header, with the desired types
std::optional<std::string> little_endian_bytes(PlyReader& reader, const std::vector<PlyElement>& elements);

} // namespace cageform_support
