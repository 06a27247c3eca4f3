#include "../catch.hpp"
#include "../support/cages.hpp"

#include <cageform/adapt/eigen.hpp>
#include <cageform/cage/polygon.hpp>

#include <span>
#include <vector>

namespace eigen_tests {

using cageform::MutablePoint;
using cageform::MutablePointRange;
using cageform::Point;
using cageform::PointRange;
using cageform::points_in_columns;
using cageform::points_in_rows;
using cageform::PointTraits;
using cageform::Vec;
using cageform_tests::Random;

namespace {

template <class M>
void fill(M& matrix, Random& random) {
    using T = typename M::Scalar;
    for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
        for (Eigen::Index j = 0; j < matrix.cols(); ++j) matrix(i, j) = T(random.uniform(-1, 1));
    }
}

/// `points` views rows first_row … and columns first_column … of `whole`; a point is a row or a column.
/// Reads must agree with the matrix's own (i, j), and writes change those entries and no others.
template <class Points, class M>
void check_view(const Points& points, M& whole, bool in_rows, Eigen::Index first_row,
                Eigen::Index first_column) {
    using T = typename M::Scalar;
    constexpr std::size_t D = cageform::range_dimension<Points>;
    const auto entry = [&](M& matrix, std::size_t i, std::size_t k) -> T& {
        return matrix(first_row + Eigen::Index(in_rows ? i : k),
                      first_column + Eigen::Index(in_rows ? k : i));
    };
    M expected = whole;
    for (std::size_t i = 0; i < points.size(); ++i) {
        Vec<T, D> p{};
        for (std::size_t k = 0; k < D; ++k) {
            CHECK(points[i][k] == entry(whole, i, k));
            p[k] = entry(expected, i, k) = T(100 * i + k);
        }
        points.store(i, p);
    }
    CHECK(whole == expected);
}

} // namespace

TEST_CASE("Eigen vectors of fixed size are points", "[adapt][eigen]") {
    STATIC_REQUIRE(MutablePoint<Eigen::Vector2f>);
    STATIC_REQUIRE(MutablePoint<Eigen::Vector3d>);
    STATIC_REQUIRE(MutablePoint<Eigen::RowVector2d>);
    STATIC_REQUIRE(MutablePoint<Eigen::Matrix<double, 5, 1>>);
    STATIC_REQUIRE(MutablePoint<Eigen::Matrix<float, 1, 2, Eigen::RowMajor | Eigen::DontAlign>>);
    STATIC_REQUIRE(PointTraits<Eigen::Vector2f>::dimension == 2);
    STATIC_REQUIRE(PointTraits<Eigen::RowVector3d>::dimension == 3);
    STATIC_REQUIRE(std::is_same_v<PointTraits<Eigen::Vector2f>::scalar, float>);

    STATIC_REQUIRE(!Point<Eigen::VectorXd>);
    STATIC_REQUIRE(!Point<Eigen::RowVectorXf>);
    STATIC_REQUIRE(!Point<Eigen::Matrix2d>);
    STATIC_REQUIRE(!Point<Eigen::MatrixXd>);
    STATIC_REQUIRE(!Point<Eigen::Matrix2Xd>);
    STATIC_REQUIRE(!Point<decltype(Eigen::Vector2d() + Eigen::Vector2d())>); // an expression has no memory
}

TEST_CASE("Eigen vectors are read and written by axis", "[adapt][eigen]") {
    const auto check = [](auto p) {
        using P = decltype(p);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            PointTraits<P>::set(p, axis, typename PointTraits<P>::scalar(axis + 1));
        }
        CHECK((p[0] == 1 && p[1] == 2 && p[2] == 3));
        CHECK(PointTraits<P>::get(p, 2) == 3);
        CHECK(cageform::to_vec<double>(p) == Vec<double, 3>{1, 2, 3});
    };
    check(Eigen::Vector3f());
    check(Eigen::Vector3d());
    check(Eigen::RowVector3d());
}

TEST_CASE("ranges of Eigen vectors are ranges of points", "[adapt][eigen]") {
    STATIC_REQUIRE(MutablePointRange<std::vector<Eigen::Vector2f>>);
    STATIC_REQUIRE(PointRange<std::span<const Eigen::Vector3d>>);
    STATIC_REQUIRE(!PointRange<std::vector<Eigen::VectorXd>>);
    const std::vector<Eigen::Vector2f> triangle{{0, 0}, {4, 0}, {0, 3}};
    const cageform::Polygon cage(triangle);
    STATIC_REQUIRE(std::is_same_v<decltype(cage), const cageform::Polygon<float>>);
    CHECK(cage[2] == Vec<float, 2>{0, 3});
}

TEMPLATE_TEST_CASE("rows and columns of a matrix in either order are points", "[adapt][eigen]",
                   (Eigen::Matrix<float, -1, -1, Eigen::RowMajor>),
                   (Eigen::Matrix<float, -1, -1, Eigen::ColMajor>),
                   (Eigen::Matrix<double, -1, -1, Eigen::RowMajor>),
                   (Eigen::Matrix<double, -1, -1, Eigen::ColMajor>)) {
    Random random{1};
    SECTION("whole matrices") {
        TestType by_rows(7, 2);
        fill(by_rows, random);
        REQUIRE(points_in_rows<2>(by_rows).size() == 7);
        check_view(points_in_rows<2>(by_rows), by_rows, true, 0, 0);
        TestType by_columns(3, 6);
        fill(by_columns, random);
        REQUIRE(points_in_columns<3>(by_columns).size() == 6);
        check_view(points_in_columns<3>(by_columns), by_columns, false, 0, 0);
    }
    SECTION("blocks of larger matrices") {
        TestType large(9, 8);
        fill(large, random);
        check_view(points_in_rows<3>(large.block(2, 4, 5, 3)), large, true, 2, 4);
        fill(large, random);
        check_view(points_in_columns<2>(large.block(6, 1, 2, 7)), large, false, 6, 1);
        fill(large, random);
        check_view(points_in_rows<2>(large.template rightCols<2>()), large, true, 0, 6);
        fill(large, random);
        check_view(points_in_columns<3>(large.topRows(3)), large, false, 0, 0);
    }
    SECTION("a transpose") {
        TestType large(2, 5);
        fill(large, random);
        check_view(points_in_rows<2>(large.transpose()), large, false, 0, 0);
    }
    SECTION("nothing") {
        TestType none(0, 2);
        CHECK(points_in_rows<2>(none).size() == 0);
    }
    SECTION("const matrices give read-only points") {
        TestType matrix(4, 2);
        fill(matrix, random);
        const TestType& fixed = matrix;
        const auto points = points_in_rows<2>(fixed);
        const auto block = points_in_rows<2>(fixed.middleRows(1, 2));
        STATIC_REQUIRE(PointRange<decltype(points)>);
        STATIC_REQUIRE(!MutablePointRange<decltype(points)>);
        STATIC_REQUIRE(!MutablePointRange<decltype(block)>);
        STATIC_REQUIRE(MutablePointRange<decltype(points_in_rows<2>(matrix))>);
        for (std::size_t i = 0; i < 4; ++i) {
            for (std::size_t k = 0; k < 2; ++k)
                CHECK(points[i][k] == matrix(Eigen::Index(i), Eigen::Index(k)));
        }
        CHECK(block[0] == points[1]);
        CHECK(block[1] == points[2]);
    }
}

TEST_CASE("rows of matrices of fixed width and of mapped memory are points", "[adapt][eigen]") {
    Random random{2};
    Eigen::Matrix<double, Eigen::Dynamic, 2> tall(5, 2);
    fill(tall, random);
    check_view(points_in_rows<2>(tall), tall, true, 0, 0);
    Eigen::Matrix<float, 3, 4> fixed;
    fill(fixed, random);
    check_view(points_in_columns<3>(fixed), fixed, false, 0, 0);

    // Every third float of a buffer is an x, followed by its y.
    std::vector<float> buffer{1, 2, -1, 3, 4, -1, 5, 6, -1};
    using Rows = Eigen::Matrix<float, Eigen::Dynamic, 2, Eigen::RowMajor>;
    Eigen::Map<Rows, 0, Eigen::OuterStride<3>> mapped(buffer.data(), 3, 2);
    const auto points = points_in_rows<2>(mapped);
    CHECK(points[2] == Vec<float, 2>{5, 6});
    points.store(1, {30, 40});
    CHECK(buffer == std::vector<float>{1, 2, -1, 30, 40, -1, 5, 6, -1});

    const float constant[] = {1, 2, 3, 4};
    const Eigen::Map<const Rows> read_only(constant, 2, 2);
    CHECK(points_in_rows<2>(read_only)[1] == Vec<float, 2>{3, 4});
    STATIC_REQUIRE(!MutablePointRange<decltype(points_in_rows<2>(read_only))>);
}

TEST_CASE("a polygon can be made from the rows of a matrix", "[adapt][eigen]") {
    Eigen::MatrixXd square(4, 2);
    square << 0, 0, 1, 0, 1, 1, 0, 1;
    const cageform::Polygon cage(points_in_rows<2>(square));
    STATIC_REQUIRE(std::is_same_v<decltype(cage), const cageform::Polygon<double>>);
    REQUIRE(cage.size() == 4);
    CHECK(cage[1] == Vec<double, 2>{1, 0});
    CHECK(cage[3] == Vec<double, 2>{0, 1});
}

} // namespace eigen_tests
