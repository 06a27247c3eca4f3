#include "../catch.hpp"

#include <cageform/core/status.hpp>

#include <set>
#include <string>

namespace status_tests {

using cageform::PointState;
using cageform::Status;

namespace {

/// The names of the enumerators 0 … last. A forgotten case of the switch, or an enumerator after `last` that
/// this test does not know yet, shows in the name of the number after `last`.
template <class Enum>
void check_names(Enum last, const std::string& unknown) {
    std::set<std::string> names;
    for (unsigned value = 0; value <= unsigned(last); ++value) {
        CAPTURE(value);
        const std::string name = to_string(Enum(value));
        CHECK(!name.empty());
        CHECK(name != unknown);
        CHECK(name.back() != '.');
        CHECK(names.insert(name).second);
    }
    CHECK(to_string(Enum(unsigned(last) + 1)) == unknown);
}

} // namespace

TEST_CASE("every status has its own text", "[core][status]") {
    check_names(Status::influences_not_supported, "unknown status");
}

TEST_CASE("every point state has its own name", "[core][status]") {
    check_names(PointState::unreached, "unknown");
}

TEST_CASE("the first status is ok, and to_string is constexpr", "[core][status]") {
    STATIC_REQUIRE(Status{} == Status::ok);
    STATIC_REQUIRE(to_string(Status::ok)[0] == 'o');
    STATIC_REQUIRE(to_string(PointState::inside)[0] == 'i');
    STATIC_REQUIRE(sizeof(Status) == 1);
}

} // namespace status_tests
