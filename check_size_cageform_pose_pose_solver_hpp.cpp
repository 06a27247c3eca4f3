#include <cageform/pose/pose_solver.hpp>
