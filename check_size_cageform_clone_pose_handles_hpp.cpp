#include <cageform/clone/pose_handles.hpp>
