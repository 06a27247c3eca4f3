// Loaded before a program, by LD_PRELOAD: reading the file that $FAILING_FILE names fails after
// $FAILING_AFTER bytes, as a disk does that is broken there.
#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <string>
#include <string_view>

#include <dlfcn.h>
#include <unistd.h>

extern "C" ssize_t read(int file, void* buffer, size_t count) {
    using Read = ssize_t (*)(int, void*, size_t);
    static const auto next = reinterpret_cast<Read>(dlsym(RTLD_NEXT, "read"));
    const char* const name = std::getenv("FAILING_FILE");
    const char* const after = std::getenv("FAILING_AFTER");
    if (name == nullptr || after == nullptr) return next(file, buffer, count);
    std::array<char, 4096> path{};
    const std::string link = "/proc/self/fd/" + std::to_string(file);
    const ssize_t size = readlink(link.c_str(), path.data(), path.size());
    if (size < 0 || !std::string_view(path.data(), size_t(size)).ends_with(name))
        return next(file, buffer, count);
    const auto left = off_t(std::atoll(after)) - lseek(file, 0, SEEK_CUR);
    if (left <= 0) {
        errno = EIO;
        return -1;
    }
    return next(file, buffer, std::min(count, size_t(left)));
}
