// Writes glTF documents and the files that they refer to.

#include "files/gltf_document.hpp"

#include "io/base64.hpp"
#include "io/input_file.hpp"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <iterator>

namespace cageform_support {

std::string detail::percent_decoded(std::string_view uri) {
    std::string text;
    for (std::size_t i = 0; i < uri.size(); ++i) {
        unsigned value = 0;
        const bool is_code =
            uri[i] == '%' && i + 2 < uri.size() &&
            std::from_chars(uri.data() + i + 1, uri.data() + i + 3, value, 16).ptr == uri.data() + i + 3;
        text += is_code ? char(value) : uri[i];
        if (is_code) i += 2;
    }
    return text;
}

/// Encodes the characters of a file name that a URI does not allow.
static std::string percent_encoded(std::string_view name) {
    constexpr std::string_view digits = "0123456789ABCDEF";
    std::string uri;
    for (const char c : name) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte > 32 && byte < 127 && std::string_view("\"%<>\\^`{|}#?").find(c) == std::string_view::npos)
            uri += c;
        else
            (uri += '%').append({digits[byte >> 4], digits[byte & 15]});
    }
    return uri;
}

bool detail::has_scheme(const std::string& uri) {
    const std::size_t colon = uri.find(':');
    return colon != std::string::npos && uri.find_first_of("/?#") > colon;
}

/// The JSON, with the indentation of the file; the text of the file if nothing has changed.
///
///   new_indent   for documents that were not read from a .gltf file
std::string GltfDocument::json_text(const GltfJson& whole_json, int new_indent) const {
    int indent = is_binary_ || text_.empty() ? new_indent : 2;
    if (!text_.empty()) {
        if (GltfJson::parse(text_) == whole_json) return text_;
        const std::size_t line = text_.find('\n'), word = text_.find_first_not_of(" \t\r\n", line);
        if (line != std::string::npos && word != std::string::npos)
            indent = int(std::min(word - line - 1, std::size_t{8}));
    }
    return whole_json.dump(indent, ' ', false, GltfJson::error_handler_t::replace);
}

Expected<std::vector<WrittenFile>> GltfDocument::files(const std::filesystem::path& path) const {
    std::size_t bytes = 0;
    for (const Buffer& buffer : buffers_) bytes += buffer.bytes.size();
    if (bytes > largest_mesh_file)
        return FileError{path.string() + ": would have more than 2000 MB, the limit for meshes"};
    GltfJson whole_json = json;
    std::vector<WrittenFile> images;
    try {
        images = copied_images(path, whole_json);
    } catch (const GltfFault& fault) {
        return FileError{path_ + ": " + fault.what()};
    }
    auto files = lowercase_extension(path) == ".glb" ? glb_files(path, std::move(whole_json))
                                                     : gltf_files(path, std::move(whole_json));
    std::move(images.begin(), images.end(), std::back_inserter(files));
    return files;
}

/// Whether two files are in the same folder.
static bool are_in_one_folder(const std::filesystem::path& a, const std::filesystem::path& b) {
    const auto folder = [](const std::filesystem::path& path) {
        return path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
    };
    std::error_code error;
    return folder(a) == folder(b) || std::filesystem::equivalent(folder(a), folder(b), error);
}

static auto find_path(const std::vector<WrittenFile>& files, const std::filesystem::path& path) {
    return std::find_if(files.begin(), files.end(),
                        [&](const WrittenFile& file) { return file.path == path; });
}

/// The file name of a path, with a number appended where it is taken.
template <class Taken>
static std::filesystem::path free_name(const std::filesystem::path& path, const Taken& is_taken) {
    std::filesystem::path name = path.filename();
    for (std::size_t n = 1; is_taken(name); ++n)
        name = path.stem().string() + '_' + std::to_string(n) + path.extension().string();
    return name;
}

/// For an output in another folder: sets the URIs of images, and returns their files.
std::vector<WrittenFile> GltfDocument::copied_images(const std::filesystem::path& path,
                                                     GltfJson& whole_json) const {
    std::vector<WrittenFile> files;
    if (path_.empty() || are_in_one_folder(path, path_)) return files;
    for (GltfIndex i = 0; i < array("images").size(); ++i) {
        const std::string user = "image " + std::to_string(i);
        const std::string uri = object("images", i, user).value("uri", std::string());
        if (uri.empty() || detail::has_scheme(uri)) continue;
        std::string bytes = read_beside(uri, user);
        bool is_there = false; // whether a file has the same bytes
        const std::filesystem::path name =
            free_name(detail::percent_decoded(uri), [&](const std::filesystem::path& candidate) {
                const auto place = path.parent_path() / candidate;
                const auto same = find_path(files, place);
                is_there = same != files.end() || std::filesystem::exists(place);
                if (!is_there) return false;
                return (same != files.end() ? same->bytes : read_file(place.string()).value_or({})) != bytes;
            });
        whole_json["images"][i]["uri"] = percent_encoded(name.string());
        if (!is_there) files.push_back({path.parent_path() / name, std::move(bytes)});
    }
    return files;
}

std::vector<WrittenFile> GltfDocument::glb_files(const std::filesystem::path& path,
                                                 GltfJson whole_json) const {
    std::vector<WrittenFile> files(1);
    std::string bytes;
    if (is_binary_ && !repacks_ && !buffers_.empty()) {
        bytes = buffers_[0].bytes;
        whole_json["buffers"][0]["byteLength"] = bytes.size();
        write_buffers(1, path, whole_json, files);
    } else {
        bytes = packed_bytes(whole_json);
    }
    std::string head = json_text(whole_json, -1); // 4.4
    head.resize((head.size() + 3) / 4 * 4, ' ');
    bytes.resize((bytes.size() + 3) / 4 * 4);
    const auto number = [](std::size_t n) {
        const auto word = static_cast<std::uint32_t>(n);
        return std::string(
            {char(word & 255), char(word >> 8 & 255), char(word >> 16 & 255), char(word >> 24)});
    };
    const std::size_t binary = bytes.empty() ? 0 : 8 + bytes.size();
    std::string file =
        "glTF" + number(2) + number(12 + 8 + head.size() + binary) + number(head.size()) + "JSON" + head;
    if (binary > 0) file.append(number(bytes.size())).append("BIN\0", 4).append(bytes);
    files[0] = {path, std::move(file)};
    return files;
}

/// Moves the bytes of all buffer views into one buffer. Bytes that no buffer view uses are left out.
std::string GltfDocument::packed_bytes(GltfJson& whole_json) const {
    std::vector<std::array<std::size_t, 3>> ranges; // buffer, begin, index of the view
    const std::size_t views = array("bufferViews").size();
    for (std::size_t i = 0; i < views; ++i) {
        const GltfJson& view = json["bufferViews"][i];
        ranges.push_back({view.value("buffer", std::size_t{0}), view.value("byteOffset", std::size_t{0}), i});
    }
    std::sort(ranges.begin(), ranges.end());
    std::string bytes;
    std::size_t buffer = gltf_none, source = 0, copied = 0; // of the last range that was copied
    for (const auto& [own, begin, view] : ranges) {
        const std::size_t size = json["bufferViews"][view].value("byteLength", std::size_t{0});
        if (own >= buffers_.size() || begin > buffers_[own].bytes.size() ||
            size > buffers_[own].bytes.size() - begin)
            continue;                                   // not used by any accessor that was read
        if (own != buffer || begin > source + copied) { // the offset stays the same modulo 8
            buffer = own;
            source = begin;
            copied = 0;
            bytes.resize((bytes.size() + 7) / 8 * 8 + begin % 8);
        }
        if (begin + size > source + copied) {
            bytes.append(buffers_[own].bytes, source + copied, begin + size - source - copied);
            copied = begin + size - source;
        }
        whole_json["bufferViews"][view]["byteOffset"] = bytes.size() - copied + begin - source;
        whole_json["bufferViews"][view]["buffer"] = 0;
    }
    whole_json.erase("buffers");
    if (!bytes.empty()) whole_json["buffers"] = {{{"byteLength", bytes.size()}}};
    return bytes;
}

std::vector<WrittenFile> GltfDocument::gltf_files(const std::filesystem::path& path,
                                                  GltfJson whole_json) const {
    std::vector<WrittenFile> files(1);
    if (repacks_) {
        GltfDocument packed = *this;
        packed.buffers_ = {{packed_bytes(whole_json), {}, false, true}};
        packed.write_buffers(0, path, whole_json, files);
    } else {
        write_buffers(0, path, whole_json, files);
    }
    files[0] = {path, json_text(whole_json, 1) + (text_.empty() ? "\n" : "")};
    return files;
}

/// Sets the URIs of buffers, and appends their files where these have changed or are in another folder.
///
///   first   index of the first buffer that is not in the file itself
void GltfDocument::write_buffers(std::size_t first, const std::filesystem::path& path, GltfJson& whole_json,
                                 std::vector<WrittenFile>& files) const {
    const bool is_here = are_in_one_folder(path, path_);
    for (std::size_t i = first; i < buffers_.size(); ++i) {
        const Buffer& buffer = buffers_[i];
        GltfJson& own = whole_json["buffers"][i];
        const bool is_data = buffer.is_data || text_.empty();
        if (!buffer.is_changed && (buffer.is_data || (is_here && !buffer.uri.empty()))) continue;
        if (buffer.is_changed) own["byteLength"] = buffer.bytes.size();
        if (is_data) {
            own["uri"] = "data:application/octet-stream;base64," + base64(buffer.bytes);
            continue;
        }
        std::filesystem::path name = path.stem();
        name += (i == 0 ? std::string() : '_' + std::to_string(i)) + ".bin";
        if (!is_here && !buffer.is_changed && !buffer.uri.empty()) name = detail::percent_decoded(buffer.uri);
        name = free_name(name, [&](const std::filesystem::path& candidate) {
            const auto has_it = [&](const Buffer& other) { // and keeps it
                return is_here && !other.is_changed && detail::percent_decoded(other.uri) == candidate;
            };
            return find_path(files, path.parent_path() / candidate) != files.end() ||
                   std::any_of(buffers_.begin(), buffers_.end(), has_it);
        });
        own["uri"] = percent_encoded(name.string());
        files.push_back({path.parent_path() / name, buffer.bytes});
    }
}

Expected<std::size_t> save_gltf(const GltfDocument& document, const std::string& path, OutputFiles& outputs) {
    std::size_t bytes = 0;
    try {
        const auto files = document.files(path);
        if (!files) return files.error();
        for (const WrittenFile& file : *files) {
            outputs.add(file.path).write(file.bytes);
            bytes += file.bytes.size();
        }
    } catch (const GltfJson::exception& fault) {
        return json_error(path, fault);
    }
    return bytes;
}

} // namespace cageform_support
