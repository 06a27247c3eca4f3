// The macros that windows.h and its includes define on plain words; included by force before anything
// else. Headers of other projects come first: libstdc++ would undefine min and max again, and their use
// of these words is not ours to mend.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <glm/glm.hpp>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cassert>
#include <cfloat>
#include <charconv>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <exception>
#include <functional>
#include <initializer_list>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <numbers>
#include <numeric>
#include <optional>
#include <queue>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#define min(a, b) (((a) < (b)) ? (a) : (b))
#define max(a, b) (((a) > (b)) ? (a) : (b))

// No C++ has an @: wherever one of these words stands, it is an error.
#define near @
#define far @
#define small @
#define hyper @
#define interface @
#define pascal @
#define cdecl @
#define ABSOLUTE @
#define ALTERNATE @
#define CALLBACK @
#define CONST @
#define DELETE @
#define DIFFERENCE @
#define DOMAIN @
#define DUPLICATE @
#define ERROR @
#define FALSE @
#define FAR @
#define IGNORE @
#define IN @
#define INFINITE @
#define INTERFACE @
#define NEAR @
#define OPAQUE @
#define OPTIONAL @
#define OUT @
#define OVERFLOW @
#define PLANES @
#define PURE @
#define REGISTERED @
#define RELATIVE @
#define RGB @
#define STRICT @
#define THIS @
#define TRANSPARENT @
#define TRUE @
#define UNDERFLOW @
#define VOID @
#define WINDING @
#define CreateFont @
#define DrawText @
#define FindText @
#define GetMessage @
#define GetObject @
#define LoadImage @
#define MoveMemory @
#define SendMessage @
#define Yield @
