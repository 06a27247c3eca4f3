// What nearly all tests include and no change of the library touches; compiled once for all test programs.
#pragma once

#include "../catch.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <glm/glm.hpp>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>
