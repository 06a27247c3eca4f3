#include "../catch.hpp"

#include <cageform/core/status.hpp>

#include <set>
#include <string>

namespace status_tests {

using cageform::PointState;
using cageform::Status;

namespace {

/// Checks the names of the enumerators 0, 1, … up to the first number that `to_string` calls `unknown`.
/// Returns the number of names.
template <class Enum>
unsigned check_names(const std::string& unknown) {
    std::set<std::string> names;
    for (unsigned value = 0; to_string(Enum(value)) != unknown; ++value) {
        CAPTURE(value);
        const std::string name = to_string(Enum(value));
        REQUIRE(names.insert(name).second);
        CHECK(!name.empty());
        CHECK(name.back() != '.');
    }
    return unsigned(names.size());
}

} // namespace

TEST_CASE("every status has its own text", "[core][status]") {
    CHECK(check_names<Status>("unknown status") > unsigned(Status::index_out_of_range));
}

TEST_CASE("every point state has its own name", "[core][status]") {
    CHECK(check_names<PointState>("unknown") == unsigned(PointState::unreached) + 1);
}

TEST_CASE("the first status is ok, and to_string is constexpr", "[core][status]") {
    STATIC_REQUIRE(Status{} == Status::ok);
    STATIC_REQUIRE(to_string(Status::ok)[0] == 'o');
    STATIC_REQUIRE(to_string(PointState::inside)[0] == 'i');
    STATIC_REQUIRE(sizeof(Status) == 1);
}

} // namespace status_tests
