#pragma once

// Reading PLY files of any size in blocks of records: ASCII, binary of either byte order.

#include "io/input_file.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace cageform_support {

/// The text for --help.
inline constexpr const char* ply_format =
    "PLY files are ASCII or binary, of either byte order. The numbers of an element can be\n"
    "of any type; elements and properties that a program does not need are skipped, lists\n"
    "too.\n";

enum class PlyEncoding : std::uint8_t { ascii, little_endian, big_endian };
enum class PlyType : std::uint8_t { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

/// Returns the type of an old or new name, such as uchar and uint8; none for other words.
std::optional<PlyType> ply_type(std::string_view name);

/// Returns the older name, which all readers know.
std::string_view name_of(PlyType type);

/// Returns the size of a number in bytes.
std::size_t bytes_of(PlyType type);

/// Appends a number as a little-endian file has it. One that its type does not hold becomes the nearest that
/// it holds, and NaN as a whole number 0.
void append_number(std::string& bytes, PlyType type, double number);

/// Returns the words of a line of the header.
std::vector<std::string_view> ply_words(std::string_view line);

struct PlyProperty {
    std::string name;
    PlyType type = PlyType::float32;
    std::optional<PlyType> count; ///< of a list: the type of its length; else none
};

struct PlyElement {
    std::string name;
    std::uint64_t count = 0;
    std::vector<PlyProperty> properties;

    std::optional<std::size_t> find(std::string_view property) const; ///< its number, if there is one
    std::optional<std::size_t> record_bytes() const; ///< in a binary file; none where there are lists
};

struct PlyHeader {
    PlyEncoding encoding = PlyEncoding::ascii;
    std::vector<std::string> comments; ///< in their order, with lines of "obj_info", less the first word
    std::vector<PlyElement> elements;

    const PlyElement* find(std::string_view element) const; ///< null where there is none
};

/// A PLY file that is read from its beginning, in blocks of records. It holds one block in memory.
class PlyReader {
public:
    /// Reads the header. error() says why there is none: the file cannot be read, or is no PLY file.
    explicit PlyReader(const std::string& path);

    const PlyHeader& header() const { return header_; }
    const std::string& error() const { return error_; } ///< the first failure; empty while there is none
    bool may_pass() const { return file_.may_pass(); }  ///< InputFile::may_pass
    /// InputFile::hash_to_end: nothing more is read() after it.
    std::optional<std::uint64_t> hash_to_end();

    /// Goes to the records of an element and chooses what read() returns of them. Fails where there is no
    /// such element or property, where it lies before one that has been read, and where the file is too short
    /// for its records.
    bool begin(std::string_view element, const std::vector<std::string>& properties);

    /// Appends the chosen numbers of the next records, in the order of the choice: of `most` records, or of
    /// all that are left. A list is appended as its length and its numbers. Returns the number of records; 0
    /// at their end and after a failure: the file ends too early, or a word is no number.
    std::size_t read(std::size_t most, std::vector<double>& numbers);

    /// Returns the number of the next record of the element.
    std::uint64_t position() const { return position_; }

private:
    bool fail(const std::string& why);
    bool fill(std::size_t bytes); // until so many are in the buffer; false where it cannot
    std::optional<std::string_view> take_line();
    bool read_header();
    bool read_property(std::string_view line);
    bool skip(std::uint64_t records);
    bool read_record(std::vector<double>* numbers);
    bool read_binary(std::vector<double>* numbers);
    bool read_line(std::vector<double>* numbers);
    bool take_number(PlyType type, double& number);
    std::string place() const;
    bool fits(const PlyElement& element) const;

    std::string path_, error_;
    InputFile file_;
    PlyHeader header_;
    std::string buffer_;
    std::size_t at_ = 0; // in the buffer
    std::uint64_t line_ = 0;
    std::size_t element_ = 0;                    // the one whose records come next
    std::uint64_t position_ = 0;                 // in it
    std::vector<std::size_t> chosen_;            // properties, in the order of the caller
    std::vector<std::size_t> offsets_;           // of the chosen in a record without lists
    std::vector<std::vector<double>> of_record_; // by property
};

/// Returns a file that reader has just begun as a binary little-endian one; nothing where the reader fails.
///
///   elements   those of the header, with the types that the numbers get
std::optional<std::string> little_endian_bytes(PlyReader& reader, const std::vector<PlyElement>& elements);

} // namespace cageform_support
