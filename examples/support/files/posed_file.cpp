#include "files/posed_file.hpp"

#include "files/obj_file.hpp"
#include "io/csv.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

namespace cageform_support {

namespace detail {

template <class X>
void append_bytes(std::string& text, const X& value) {
    std::array<char, sizeof(X)> bytes;
    std::memcpy(bytes.data(), &value, sizeof(X));
    text.append(bytes.data(), bytes.size());
}

/// The double that the fewest digits of `value` denote. Its text has the same digits, and vertices at rest
/// equal those of the file.
template <class T>
double as_written(T value) {
    std::string digits;
    append_digits(digits, value);
    double number = 0;
    (void)parse_number(digits, number);
    return number;
}

std::string ply_head(PosedFormat format, std::size_t scalar_bytes, std::size_t points) {
    const char* const order = std::endian::native == std::endian::little ? "little" : "big";
    std::string head = "ply\nformat ";
    head += format == PosedFormat::ply_text ? "ascii" : "binary_" + std::string(order) + "_endian";
    head += " 1.0\nelement vertex " + std::to_string(points) + '\n';
    for (const char* axis : {"x", "y", "z"})
        head += std::string("property ") + (scalar_bytes == 4 ? "float " : "double ") + axis + '\n';
    return head;
}

std::string npy_head(std::size_t dimension, std::size_t scalar_bytes, std::size_t points) {
    std::string text = std::string("{'descr': '") + (std::endian::native == std::endian::little ? '<' : '>') +
                       'f' + std::to_string(scalar_bytes) + "', 'fortran_order': False, 'shape': (" +
                       std::to_string(points) + ", " + std::to_string(dimension) + "), }";
    constexpr std::size_t prefix = 10, whole = 64; // the array begins at a multiple of 64
    text.append(whole - 1 - (prefix + text.size()) % whole, ' ');
    text += '\n';
    const auto length = std::uint16_t(text.size());
    return std::string("\x93NUMPY\x01\x00", 8) + char(length & 0xff) + char(length >> 8) + text;
}

} // namespace detail

PosedFile::PosedFile(PosedFormat format, std::size_t dimension, std::size_t scalar_bytes, std::size_t points,
                     Triangles triangles)
    : format_(format) {
    begin(dimension, scalar_bytes, points, triangles.size(), 3);
    for (const auto& triangle : triangles) add_face(triangle);
}

PosedFile::PosedFile(PosedFormat format, std::size_t scalar_bytes, const MeshFile& mesh)
    : format_(format)
    , mesh_(format == PosedFormat::mesh ? &mesh : nullptr) {
    if (mesh_ != nullptr) return;
    std::size_t most = 0;
    for (const MeshFace& face : mesh.faces) most = std::max(most, face.corners.size());
    begin(3, scalar_bytes, mesh.vertices.size(), mesh.faces.size(), most);
    for (const auto& corners : face_loops(mesh)) add_face(corners);
}

void PosedFile::begin(std::size_t dimension, std::size_t scalar_bytes, std::size_t points, std::size_t faces,
                      std::size_t corners) {
    many_corners_ = corners > 255;
    if (format_ == PosedFormat::npy) head_ = detail::npy_head(dimension, scalar_bytes, points);
    if (format_ != PosedFormat::ply && format_ != PosedFormat::ply_text) return;
    head_ = detail::ply_head(format_, scalar_bytes, points);
    if (faces > 0) {
        head_ += "element face " + std::to_string(faces) + "\nproperty list " +
                 (many_corners_ ? "uint" : "uchar") + " uint vertex_indices\n";
    }
    head_ += "end_header\n";
}

void PosedFile::add_face(std::span<const std::uint32_t> corners) {
    const auto count = std::uint32_t(corners.size());
    switch (format_) {
    case PosedFormat::npy:
    case PosedFormat::mesh: return;
    case PosedFormat::ply:
        if (many_corners_)
            detail::append_bytes(tail_, count);
        else
            detail::append_bytes(tail_, std::uint8_t(count));
        for (const std::uint32_t corner : corners) detail::append_bytes(tail_, corner);
        return;
    case PosedFormat::ply_text:
        tail_ += std::to_string(count);
        for (const std::uint32_t corner : corners) tail_ += ' ' + std::to_string(corner);
        tail_ += '\n';
        return;
    case PosedFormat::obj:
        tail_ += 'f';
        for (const std::uint32_t corner : corners) tail_ += ' ' + std::to_string(std::uint64_t{corner} + 1);
        tail_ += '\n';
    }
}

template <cageform::Scalar T, std::size_t D>
Expected<std::string> PosedFile::contents(std::span<const cageform::Vec<T, D>> points,
                                          std::span<const Jacobian3> jacobians) const {
    if (mesh_ != nullptr) {
        std::vector<Point3> moved(points.size());
        for (std::size_t n = 0; n < D * points.size(); ++n)
            moved[n / D][n % D] = detail::as_written(points[n / D][n % D]);
        if (mesh_->document == nullptr) return to_text(*mesh_, {moved, jacobians});
        auto written = mesh_->document->moved(*mesh_, {moved, jacobians}, {});
        if (!written) return written.error();
        return std::move(written->files.front().bytes);
    }
    const bool as_text = format_ == PosedFormat::obj || format_ == PosedFormat::ply_text;
    const std::size_t axes = format_ == PosedFormat::npy ? D : 3;
    std::string text;
    text.reserve(head_.size() + points.size() * axes * (as_text ? 12 : sizeof(T)) + tail_.size());
    text += head_;
    for (const auto& p : points) {
        if (format_ == PosedFormat::obj) text += "v ";
        for (std::size_t k = 0; k < axes; ++k) {
            const T number = k < D ? p[k] : T(0);
            if (!as_text) {
                detail::append_bytes(text, number);
                continue;
            }
            detail::append_digits(text, number);
            text += k + 1 < axes ? ' ' : '\n';
        }
    }
    text += tail_;
    return text;
}

template Expected<std::string> PosedFile::contents(std::span<const cageform::Vec<float, 2>>,
                                                   std::span<const Jacobian3>) const;
template Expected<std::string> PosedFile::contents(std::span<const cageform::Vec<float, 3>>,
                                                   std::span<const Jacobian3>) const;
template Expected<std::string> PosedFile::contents(std::span<const cageform::Vec<double, 2>>,
                                                   std::span<const Jacobian3>) const;
template Expected<std::string> PosedFile::contents(std::span<const cageform::Vec<double, 3>>,
                                                   std::span<const Jacobian3>) const;

} // namespace cageform_support
