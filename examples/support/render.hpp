#pragma once

// SVG to PNG through librsvg's own program, started without a shell.

#include <filesystem>
#include <optional>
#include <string>

namespace cageform_examples {

/// Renders `svg` to `png`, `width` pixels wide, on white. Written beside it first, then renamed.
///   returns   nothing, or why it failed; `png` is then as it was
[[nodiscard]] std::optional<std::string> render_png(const std::filesystem::path& svg,
                                                    const std::filesystem::path& png, int width);

} // namespace cageform_examples
