// Computes the tables of Izdebski 2019, ch. 6 (Bézier curves fitted in a Sobolev norm), and compares them
// with known numbers: captions of figures, Table 6.1, and results of two prototypes.
//
//     bezier_tables
//
// Each row is printed twice: our values above the known values. The largest difference of each table follows
// at the end.

#include "cli/command_line.hpp"
#include "io/messages.hpp"

#include <cageform/animate/fit.hpp>

#include <Eigen/LU>

#include <chrono>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <utility>

namespace {

using cageform::BezierCurve;
using cageform::fit_pieces;
using cageform::FitCondition;
using cageform::FitOptions;
using cageform::search_knots;
using cageform::Status;
using cageform::uniform_in_parameter;
using cageform::uniform_in_time;
using enum FitCondition;

// ---- known numbers -------------------------------------------------------------------------------

// clang-format off
constexpr std::array<std::array<double, 6>, 10> captions{{
    {0.332205, 0.139628, 0.020630, 0.012149, 0.005250, 0.003255},
    {3.155436, 0.762679, 0.174709, 0.047817, 0.030304, 0.017030},
    {5.550946, 1.480575, 0.447404, 0.227038, 0.126482, 0.055435},
    {0.651050, 0.261670, 0.037146, 0.026938, 0.009444, 0.007517},
    {11.228193, 4.709534, 1.856845, 0.609467, 0.448780, 0.325161},
    {3.265230, 2.231185, 0.434450, 0.320140, 0.116232, 0.090871},
    {2.245055, 0.737098, 0.304405, 0.102238, 0.069048, 0.050830},
    {3.775286, 0.918956, 0.385822, 0.166656, 0.090873, 0.055534},
    {7.822398, 2.032818, 0.453699, 0.290327, 0.150947, 0.066872},
    {12.347805, 4.054040, 1.674225, 0.562308, 0.379762, 0.279563}}};
constexpr std::array<std::array<double, 8>, 10> sup_errors{{
    {0.004337, 0.001334, 0.000146, 0.000066, 0.000028, 0.000013, 0.000010, 0.000006},
    {0.053680, 0.006709, 0.001835, 0.000298, 0.000126, 0.000084, 0.000038, 0.000024},
    {0.121253, 0.014146, 0.004668, 0.000926, 0.000926, 0.000235, 0.000231, 0.000069},
    {0.008520, 0.002182, 0.000221, 0.000160, 0.000042, 0.000028, 0.000014, 0.000011},
    {0.146587, 0.051044, 0.009477, 0.003414, 0.001878, 0.001878, 0.000437, 0.000437},
    {0.032674, 0.017101, 0.002046, 0.001413, 0.000557, 0.000548, 0.000253, 0.000251},
    {0.031152, 0.007088, 0.001776, 0.000388, 0.000388, 0.000388, 0.000059, 0.000059},
    {0.056104, 0.009847, 0.002383, 0.000832, 0.000372, 0.000247, 0.000117, 0.000077},
    {0.177907, 0.017430, 0.003325, 0.001821, 0.000875, 0.000272, 0.000204, 0.000204},
    {0.171336, 0.038982, 0.009771, 0.002136, 0.002136, 0.002136, 0.000323, 0.000323}}};
constexpr std::array<std::array<double, 5>, 10> pieces_needed{{
    {2, 3, 3, 1, 3},
    {3, 4, 4, 2, 4},
    {4, 4, 6, 3, 6},
    {2, 3, 3, 1, 3},
    {4, 7, 7, 4, 8},
    {3, 5, 7, 3, 5},
    {3, 4, 4, 2, 4},
    {3, 4, 5, 2, 5},
    {3, 5, 6, 3, 6},
    {4, 7, 7, 4, 7}}};
constexpr std::array<std::array<double, 7>, 10> uniform_time{{
    {0.033221, 0.024565, 0.012452, 0.005581, 0.002520, 0.001238, 0.000715},
    {0.315544, 0.099966, 0.082873, 0.047671, 0.023511, 0.010796, 0.004806},
    {0.555095, 0.169198, 0.241909, 0.084458, 0.127437, 0.049568, 0.072853},
    {0.065105, 0.026167, 0.005125, 0.002760, 0.001375, 0.000804, 0.000508},
    {1.122819, 0.546537, 0.600880, 0.252416, 0.363557, 0.123224, 0.231055},
    {0.326523, 0.223119, 0.128961, 0.082374, 0.056211, 0.040202, 0.029790},
    {0.224506, 0.083266, 0.093487, 0.025892, 0.045418, 0.010109, 0.023769},
    {0.377529, 0.156885, 0.089230, 0.056736, 0.038632, 0.027594, 0.020431},
    {0.782240, 0.221251, 0.345159, 0.126126, 0.185296, 0.077014, 0.107723},
    {1.234780, 0.457966, 0.514180, 0.142407, 0.249800, 0.055600, 0.130727}}};
constexpr std::array<std::array<double, 7>, 10> uniform_parameter{{
    {0.033221, 0.014623, 0.003378, 0.001327, 0.000708, 0.000418, 0.000265},
    {0.315544, 0.078343, 0.021597, 0.006630, 0.004012, 0.002499, 0.001592},
    {0.555095, 0.169198, 0.068175, 0.031655, 0.017877, 0.010821, 0.006758},
    {0.065105, 0.026167, 0.006104, 0.002632, 0.001346, 0.000779, 0.000490},
    {1.122819, 0.546537, 0.185684, 0.056303, 0.055058, 0.037816, 0.016797},
    {0.326523, 0.223119, 0.112148, 0.062688, 0.038113, 0.024707, 0.016839},
    {0.224506, 0.083266, 0.030440, 0.011390, 0.007084, 0.006462, 0.002183},
    {0.377529, 0.156885, 0.077578, 0.043170, 0.026192, 0.016959, 0.011550},
    {0.782240, 0.221251, 0.092984, 0.045933, 0.025338, 0.012378, 0.010010},
    {1.234780, 0.457966, 0.167422, 0.062645, 0.038963, 0.035539, 0.012009}}};
constexpr std::array<std::array<double, 13>, 30> brute_force{{
    {2, 0, 10, 0.01395, 0.07942, 0.1692, 0.02617, 0.54654, 0.22312, 0.08327, 0.09574, 0.22125, 0.45797},
    {2, 0, 20, 0.01395, 0.07851, 0.1692, 0.02617, 0.54441, 0.22312, 0.08327, 0.09154, 0.22125, 0.45797},
    {2, 0, 30, 0.01395, 0.07632, 0.1692, 0.02617, 0.47294, 0.22312, 0.07382, 0.09173, 0.22125, 0.40603},
    {2, 0, 50, 0.01395, 0.07665, 0.15219, 0.02617, 0.48413, 0.22312, 0.076, 0.09152, 0.22125, 0.41797},
    {2, 0, 80, 0.01395, 0.07634, 0.14637, 0.02617, 0.47182, 0.22312, 0.07411, 0.09154, 0.20503, 0.40761},
    {2, 1, 10, 0.01462, 0.07834, 0.1692, 0.02617, 0.47095, 0.22312, 0.07371, 0.09236, 0.22125, 0.4054},
    {2, 1, 20, 0.01398, 0.07728, 0.1466, 0.02617, 0.47095, 0.22312, 0.07371, 0.09236, 0.21024, 0.4054},
    {2, 1, 30, 0.01396, 0.07627, 0.14806, 0.02617, 0.47095, 0.22312, 0.07371, 0.0919, 0.20328, 0.4054},
    {2, 1, 50, 0.01394, 0.07648, 0.1465, 0.02617, 0.47095, 0.22312, 0.07371, 0.09148, 0.20465, 0.4054},
    {2, 1, 80, 0.01395, 0.07633, 0.1466, 0.02617, 0.46897, 0.22312, 0.07351, 0.09154, 0.20392, 0.40431},
    {3, 0, 10, 0.0032, 0.01731, 0.04994, 0.00377, 0.36572, 0.05724, 0.04669, 0.04375, 0.07479, 0.25677},
    {3, 0, 20, 0.00205, 0.01725, 0.04994, 0.00377, 0.18411, 0.04172, 0.03453, 0.0383, 0.07367, 0.18994},
    {3, 0, 30, 0.00216, 0.0172, 0.04994, 0.00377, 0.22456, 0.04267, 0.03049, 0.03867, 0.06792, 0.16771},
    {3, 0, 50, 0.00205, 0.01716, 0.04994, 0.00377, 0.19585, 0.04174, 0.03079, 0.03828, 0.04485, 0.16933},
    {3, 0, 80, 0.002, 0.01717, 0.04547, 0.00369, 0.18411, 0.04172, 0.03047, 0.03811, 0.04209, 0.16759},
    {3, 1, 10, 0.00247, 0.01747, 0.05113, 0.00428, 0.23744, 0.04344, 0.03566, 0.03874, 0.07094, 0.19613},
    {3, 1, 20, 0.002, 0.01747, 0.04703, 0.00414, 0.18645, 0.04344, 0.03239, 0.03874, 0.04278, 0.17813},
    {3, 1, 30, 0.00206, 0.01747, 0.04474, 0.00371, 0.18568, 0.04344, 0.03044, 0.03858, 0.04537, 0.16742},
    {3, 1, 50, 0.00202, 0.01718, 0.04505, 0.00373, 0.18364, 0.0416, 0.03089, 0.03822, 0.04222, 0.16988},
    {3, 1, 80, 0.002, 0.01711, 0.04465, 0.00369, 0.18404, 0.04168, 0.03058, 0.03811, 0.04127, 0.16818},
    {4, 0, 10, 0.00201, 0.00764, 0.02777, 0.00291, 0.0569, 0.0371, 0.01392, 0.01715, 0.03597, 0.07655},
    {4, 0, 20, 0.00121, 0.00706, 0.02777, 0.00276, 0.0569, 0.03221, 0.00978, 0.01685, 0.03364, 0.05381},
    {4, 0, 30, 0.00133, 0.00541, 0.02777, 0.00263, 0.0569, 0.03235, 0.01021, 0.01663, 0.03122, 0.05616},
    {4, 0, 50, 0.00121, 0.00471, 0.02681, 0.00264, 0.0569, 0.03206, 0.00991, 0.01668, 0.03082, 0.0545},
    {4, 0, 80, 0.00119, 0.00474, 0.02281, 0.00263, 0.0569, 0.03186, 0.00978, 0.01663, 0.02762, 0.05381},
    {4, 1, 10, 0.00166, 0.00652, 0.02891, 0.0032, 0.08914, 0.0333, 0.01046, 0.01866, 0.03202, 0.05751},
    {4, 1, 20, 0.00121, 0.00541, 0.02428, 0.00263, 0.0563, 0.03254, 0.01046, 0.0179, 0.03097, 0.05751},
    {4, 1, 30, 0.00121, 0.00478, 0.0227, 0.00269, 0.06095, 0.03201, 0.01022, 0.01667, 0.02903, 0.05623},
    {4, 1, 50, 0.00118, 0.0047, 0.02277, 0.00265, 0.05802, 0.03188, 0.00979, 0.01663, 0.02743, 0.05384},
    {4, 1, 80, 0.00119, 0.00468, 0.02261, 0.00263, 0.0563, 0.03186, 0.00983, 0.01654, 0.02751, 0.05404}}};
constexpr std::array<std::array<double, 12>, 12> uniform_over_brute{{
    {20, 2, 1.05, 1.01, 1.15, 1, 1.16, 1, 1.13, 1.7, 1.05, 1.13},
    {20, 3, 1.69, 1.24, 1.45, 1.48, 1, 2.58, 0.94, 2, 2.17, 0.94},
    {20, 4, 1.1, 1.23, 1.3, 1, 1, 1.93, 1.09, 2.41, 1.48, 1.09},
    {20, 5, 1.26, 1.07, 1.29, 1.34, 1.18, 3.13, 1, 2.85, 1.37, 1},
    {20, 6, 1.16, 1.4, 1.75, 0.99, 1.11, 2.55, 1.2, 2.78, 1.57, 1.2},
    {20, 7, 1.21, 1.26, 1.44, 1.05, 1.06, 3.02, 0.86, 2.92, 1.71, 0.86},
    {30, 2, 1.05, 1.03, 1.14, 1, 1.16, 1, 1.13, 1.71, 1.09, 1.13},
    {30, 3, 1.64, 1.24, 1.52, 1.64, 1, 2.58, 1, 2.01, 2.05, 1},
    {30, 4, 1.09, 1.39, 1.39, 0.98, 0.92, 1.96, 1.11, 2.59, 1.58, 1.11},
    {30, 5, 1.35, 1.32, 1.41, 1.43, 1.23, 3.28, 1.03, 2.88, 1.68, 1.03},
    {30, 6, 1.28, 1.47, 1.95, 1.04, 1.16, 2.72, 1.27, 3.05, 1.85, 1.27},
    {30, 7, 1.29, 1.56, 1.58, 1.24, 1.17, 3.44, 1.09, 3.34, 1.92, 1.09}}};
constexpr std::array<std::array<double, 6>, 10> optimum{{
    {0.033221, 0.013942, 0.001999, 0.001176, 0.000492, 0.000289},
    {0.315544, 0.076248, 0.017111, 0.004676, 0.002937, 0.001663},
    {0.555095, 0.146166, 0.044565, 0.022564, 0.012248, 0.005030},
    {0.065105, 0.026167, 0.003685, 0.002623, 0.000907, 0.000702},
    {1.122819, 0.468805, 0.183608, 0.056302, 0.044402, 0.031572},
    {0.326523, 0.223119, 0.041539, 0.031860, 0.011578, 0.009004},
    {0.224506, 0.073421, 0.030398, 0.009775, 0.006503, 0.004839},
    {0.377529, 0.091480, 0.038100, 0.016520, 0.008828, 0.005247},
    {0.782240, 0.203231, 0.041221, 0.027291, 0.014887, 0.005557},
    {1.234780, 0.403815, 0.167189, 0.053763, 0.035766, 0.026614}}};
constexpr std::array<std::array<double, 10>, 26> conditions_percent{{
    {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
    {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
    {44.7, 37.8, 16.9, 39.8, 0.6, 29.8, 2.3, 31.0, 3.9, 2.3},
    {50.6, 41.4, 19.2, 45.0, 0.7, 33.5, 2.8, 33.3, 4.5, 2.8},
    {46.1, 56.2, 19.8, 47.4, 71.9, 34.0, 57.6, 33.0, 76.0, 57.6},
    {52.4, 60.9, 22.1, 51.4, 73.9, 38.4, 59.2, 34.9, 80.2, 59.2},
    {45.5, 45.3, 391.2, 63.5, 195.7, 34.0, 161.2, 31.5, 700.8, 161.2},
    {51.6, 53.7, 418.2, 68.8, 265.7, 35.6, 234.1, 34.0, 709.0, 234.1},
    {493.9, 480.1, 581.6, 368.4, 286.8, 249.0, 266.0, 268.6, 828.1, 266.0},
    {66.2, 94.9, 438.2, 101.7, 235.4, 67.5, 199.4, 52.9, 797.8, 199.4},
    {15.5, 15.3, 16.3, 7.3, 9.4, 25.1, 12.8, 40.2, 13.5, 12.8},
    {16.2, 15.8, 16.9, 7.7, 9.5, 26.1, 12.9, 43.7, 13.8, 12.9},
    {79.9, 52.9, 74.9, 63.7, 44.8, 124.7, 39.0, 169.6, 89.1, 39.0},
    {85.6, 57.2, 77.1, 72.9, 45.6, 128.6, 40.6, 199.0, 97.0, 40.6},
    {67.7, 51.7, 34.4, 59.0, 10.7, 66.7, 16.5, 91.6, 18.2, 16.5},
    {70.5, 53.8, 34.9, 62.1, 10.7, 67.5, 16.7, 91.6, 18.7, 16.7},
    {70.7, 83.1, 37.5, 63.9, 77.1, 91.0, 65.1, 97.2, 77.8, 65.1},
    {73.5, 85.1, 39.1, 67.8, 79.7, 91.2, 67.2, 97.5, 81.7, 67.2},
    {169.2, 115.5, 76.0, 157.1, 47.3, 202.1, 39.2, 305.8, 103.0, 39.2},
    {267.4, 154.7, 81.2, 278.8, 47.3, 588.9, 40.7, 873.7, 120.3, 40.7},
    {195.2, 204.7, 131.8, 204.4, 216.7, 304.5, 218.8, 359.1, 136.0, 218.8},
    {69.4, 73.1, 458.5, 77.3, 225.1, 72.3, 197.9, 97.5, 803.5, 197.9},
    {72.2, 85.6, 486.5, 83.7, 289.7, 84.0, 268.6, 100.5, 817.0, 268.6},
    {626.8, 674.0, 585.7, 541.9, 320.3, 472.3, 339.5, 588.5, 1129.5, 339.5},
    {76.9, 107.9, 513.2, 377.6, 257.8, 136.0, 239.1, 136.9, 951.0, 239.1},
    {328.7, 171.6, 766.9, 190.6, 349.9, 237.5, 362.1, 449.5, 1299.8, 362.1}}};
constexpr std::array<std::array<double, 10>, 1> conditions_base{{
    {0.001999, 0.017471, 0.047031, 0.004137, 0.186448, 0.043445, 0.032387, 0.038736, 0.042783, 0.178130}}};
constexpr std::array<std::array<double, 4>, 30> degrees{{
    {0.033221, 0.013983, 0.001999, 0.001210},
    {0.032197, 0.002130, 0.000301, 0.000121},
    {0.020595, 0.000365, 0.000113, 0.000020},
    {0.315544, 0.077284, 0.017471, 0.005412},
    {0.124479, 0.018579, 0.003258, 0.001791},
    {0.124411, 0.007595, 0.000946, 0.000211},
    {0.555095, 0.146599, 0.047031, 0.024280},
    {0.457700, 0.100119, 0.020228, 0.007721},
    {0.402482, 0.049148, 0.008495, 0.003333},
    {0.065105, 0.026167, 0.004137, 0.002632},
    {0.065105, 0.001565, 0.000826, 0.000237},
    {0.008850, 0.000725, 0.000034, 0.000008},
    {1.122819, 0.470953, 0.186448, 0.056303},
    {1.122819, 0.280774, 0.121990, 0.040069},
    {0.921275, 0.154890, 0.048706, 0.015289},
    {0.326523, 0.223119, 0.043445, 0.032539},
    {0.326523, 0.099286, 0.021045, 0.008350},
    {0.099250, 0.044135, 0.003379, 0.001989},
    {0.224506, 0.073710, 0.032387, 0.010457},
    {0.224506, 0.035112, 0.017304, 0.006380},
    {0.171151, 0.014013, 0.006022, 0.002095},
    {0.377529, 0.092359, 0.038736, 0.017899},
    {0.159939, 0.023090, 0.010422, 0.002496},
    {0.109420, 0.015337, 0.003164, 0.000854},
    {0.782240, 0.210236, 0.042783, 0.030974},
    {0.599482, 0.146060, 0.023217, 0.008199},
    {0.558463, 0.079677, 0.010298, 0.002781},
    {1.234780, 0.405404, 0.178130, 0.057515},
    {1.234780, 0.193115, 0.095170, 0.035091},
    {0.941331, 0.077072, 0.033123, 0.011524}}};
constexpr std::array<std::array<double, 8>, 20> spline_ratio_time{{
    {1.80, 1.86, 1.52, 1.42, 1.40, 1.30, 1.06, 1.00},
    {1.80, 2.38, 2.91, 3.13, 2.92, 2.41, 2.27, 2.66},
    {1.30, 1.74, 1.66, 1.42, 1.32, 1.29, 1.27, 1.01},
    {1.30, 1.83, 2.39, 3.09, 3.69, 3.85, 3.14, 2.70},
    {1.15, 1.09, 1.07, 1.04, 1.02, 1.01, 1.00, 1.00},
    {1.15, 2.81, 1.75, 3.99, 2.30, 4.82, 2.84, 5.42},
    {1.53, 1.53, 1.36, 1.02, 1.01, 1.00, 1.00, 1.00},
    {1.53, 3.80, 2.41, 3.92, 2.91, 2.57, 2.34, 2.20},
    {1.08, 1.08, 1.03, 1.03, 1.01, 1.01, 1.00, 1.00},
    {1.08, 2.21, 1.44, 3.90, 1.75, 6.49, 2.06, 10.49},
    {2.26, 2.26, 1.87, 1.92, 1.81, 1.79, 1.75, 1.73},
    {2.26, 3.31, 2.54, 2.81, 2.66, 2.67, 2.63, 2.62},
    {1.10, 1.10, 1.04, 1.04, 1.01, 1.01, 1.00, 1.00},
    {1.10, 2.98, 1.66, 7.20, 2.21, 13.75, 2.73, 12.48},
    {2.56, 2.05, 2.01, 1.87, 1.83, 1.78, 1.75, 1.73},
    {2.56, 2.56, 2.85, 2.68, 2.69, 2.65, 2.64, 2.61},
    {1.17, 1.08, 1.08, 1.04, 1.02, 1.01, 1.00, 1.00},
    {1.17, 2.72, 1.77, 3.25, 2.32, 3.63, 2.86, 4.02},
    {1.10, 1.10, 1.04, 1.04, 1.01, 1.01, 1.00, 1.00},
    {1.10, 2.98, 1.66, 7.20, 2.21, 13.75, 2.73, 12.48}}};
constexpr std::array<std::array<double, 8>, 20> spline_ratio_parameter{{
    {1.80, 1.66, 1.40, 1.00, 1.03, 1.04, 1.04, 1.03},
    {1.80, 3.82, 3.03, 2.87, 2.99, 2.75, 2.51, 2.34},
    {1.30, 1.69, 1.32, 1.02, 1.04, 1.07, 1.08, 1.07},
    {1.30, 3.82, 4.90, 2.98, 4.18, 3.84, 3.24, 2.83},
    {1.15, 1.09, 1.08, 1.05, 1.03, 1.01, 1.00, 1.00},
    {1.15, 2.81, 5.26, 7.14, 7.98, 8.30, 7.51, 7.01},
    {1.53, 1.53, 1.34, 1.00, 1.00, 1.00, 1.00, 1.00},
    {1.53, 3.80, 2.48, 2.89, 2.46, 2.24, 2.12, 2.05},
    {1.08, 1.08, 1.08, 1.05, 1.02, 1.01, 1.00, 1.00},
    {1.08, 2.21, 4.43, 13.80, 5.25, 10.78, 3.16, 8.75},
    {2.26, 2.26, 1.88, 1.96, 1.83, 1.80, 1.74, 1.70},
    {2.26, 3.31, 2.63, 2.89, 2.71, 2.67, 2.59, 2.53},
    {1.10, 1.10, 1.10, 1.06, 1.01, 1.01, 1.00, 1.00},
    {1.10, 2.98, 4.34, 12.09, 4.29, 9.19, 2.60, 7.58},
    {2.56, 2.05, 2.04, 1.90, 1.85, 1.79, 1.74, 1.70},
    {2.56, 2.56, 2.93, 2.76, 2.74, 2.65, 2.59, 2.52},
    {1.17, 1.08, 1.08, 1.05, 1.03, 1.01, 1.00, 1.00},
    {1.17, 2.72, 5.57, 5.52, 8.72, 7.34, 8.04, 6.42},
    {1.10, 1.10, 1.10, 1.06, 1.01, 1.01, 1.00, 1.00},
    {1.10, 2.98, 4.34, 12.09, 4.29, 9.19, 2.60, 7.58}}};
constexpr std::array<std::array<double, 8>, 40> spline_errors{{
    {0.059891, 0.055801, 0.010236, 0.003815, 0.002116, 0.001148, 0.000666, 0.000418},
    {0.513249, 0.117784, 0.021464, 0.009938, 0.007318, 0.005988, 0.004978, 0.004223},
    {0.033221, 0.033708, 0.007295, 0.003813, 0.002061, 0.001107, 0.000641, 0.000404},
    {0.033221, 0.014623, 0.003378, 0.001327, 0.000708, 0.000418, 0.000265, 0.000178},
    {0.408924, 0.299311, 0.105788, 0.019744, 0.016787, 0.009599, 0.005162, 0.003030},
    {1.533868, 0.790197, 0.192064, 0.040534, 0.019725, 0.011874, 0.008673, 0.007346},
    {0.315544, 0.177081, 0.080304, 0.019301, 0.016074, 0.008967, 0.004792, 0.002838},
    {0.315544, 0.078343, 0.021597, 0.006630, 0.004012, 0.002499, 0.001592, 0.001071},
    {0.640754, 0.474874, 0.358763, 0.226152, 0.142590, 0.089766, 0.050727, 0.033635},
    {0.920302, 0.616110, 0.461664, 0.258044, 0.150829, 0.095150, 0.053730, 0.034517},
    {0.555095, 0.436049, 0.330979, 0.214371, 0.138811, 0.088715, 0.050490, 0.033540},
    {0.555095, 0.169198, 0.068175, 0.031655, 0.017877, 0.010821, 0.006758, 0.004799},
    {0.099562, 0.099562, 0.015121, 0.007600, 0.003309, 0.001745, 0.001040, 0.000672},
    {0.531831, 0.531831, 0.158745, 0.104143, 0.072419, 0.056345, 0.045074, 0.037294},
    {0.065105, 0.065105, 0.011288, 0.007586, 0.003299, 0.001739, 0.001035, 0.000669},
    {0.065105, 0.026167, 0.006104, 0.002632, 0.001346, 0.000779, 0.000490, 0.000328},
    {1.209356, 1.209356, 0.821994, 0.776995, 0.288945, 0.407794, 0.053048, 0.180603},
    {1.440094, 1.440094, 1.068465, 0.885636, 0.315610, 0.429349, 0.053956, 0.180363},
    {1.122819, 1.122819, 0.762353, 0.742913, 0.283782, 0.402453, 0.052941, 0.179976},
    {1.122819, 0.546537, 0.185684, 0.056303, 0.055058, 0.037816, 0.016797, 0.020643},
    {0.739569, 0.739569, 0.295219, 0.181400, 0.103147, 0.065980, 0.043590, 0.030189},
    {1.192033, 1.192033, 0.702851, 0.589975, 0.443751, 0.361976, 0.296002, 0.248365},
    {0.326523, 0.326523, 0.157072, 0.092521, 0.056287, 0.036657, 0.024985, 0.017721},
    {0.326523, 0.223119, 0.112148, 0.062688, 0.038113, 0.024707, 0.016839, 0.011947},
    {0.247777, 0.247777, 0.131997, 0.137756, 0.030382, 0.059358, 0.005686, 0.021736},
    {0.312907, 0.312907, 0.174306, 0.158338, 0.033075, 0.062820, 0.007886, 0.021714},
    {0.224506, 0.224506, 0.120483, 0.130333, 0.030120, 0.058655, 0.005663, 0.021676},
    {0.224506, 0.083266, 0.030440, 0.011390, 0.007084, 0.006462, 0.002183, 0.002869},
    {0.968197, 0.402335, 0.227028, 0.119125, 0.071662, 0.044930, 0.029858, 0.020636},
    {1.667240, 0.734803, 0.582946, 0.413523, 0.326900, 0.259425, 0.212932, 0.177729},
    {0.377529, 0.196304, 0.111117, 0.062818, 0.038635, 0.025096, 0.017112, 0.012135},
    {0.377529, 0.156885, 0.077578, 0.043170, 0.026192, 0.016959, 0.011550, 0.008190},
    {0.914088, 0.601499, 0.518021, 0.253618, 0.220928, 0.090892, 0.080462, 0.035183},
    {1.350755, 0.792519, 0.662555, 0.287163, 0.233236, 0.096567, 0.084688, 0.037351},
    {0.782240, 0.556635, 0.479050, 0.240876, 0.214808, 0.089846, 0.080084, 0.035082},
    {0.782240, 0.221251, 0.092984, 0.045933, 0.025338, 0.012378, 0.010010, 0.005484},
    {1.362775, 1.362775, 0.725982, 0.757656, 0.167104, 0.326471, 0.031271, 0.119547},
    {1.720990, 1.720990, 0.958682, 0.870857, 0.181912, 0.345512, 0.043375, 0.119424},
    {1.234780, 1.234780, 0.662657, 0.716830, 0.165661, 0.322604, 0.031147, 0.119216},
    {1.234780, 0.457966, 0.167422, 0.062645, 0.038963, 0.035539, 0.012009, 0.015778}}};
// clang-format on

constexpr std::array<const char*, 27> roman{
    "I",  "II",  "III",  "IV",    "V",   "VI", "VII", "VIII", "IX",    "X",    "XI",  "XII",  "XIII", "XIV",
    "XV", "XVI", "XVII", "XVIII", "XIX", "XX", "XXI", "XXII", "XXIII", "XXIV", "XXV", "XXVI", "XXVII"};

/// The rows of Table 6.1.
const std::array<FitCondition, 27> configurations = [] {
    const auto c0 = end_value | knot_c0, value = end_value | knot_value;
    return std::array{none,
                      c0,
                      value,
                      c0 | knot_c1,
                      value | knot_c1,
                      c0 | knot_d1,
                      value | knot_d1,
                      c0 | knot_c1 | knot_c2,
                      value | knot_c1 | knot_c2,
                      c0 | knot_c1 | knot_d2,
                      c0 | knot_d1 | knot_c2,
                      c0 | end_d1,
                      value | end_d1,
                      c0 | end_d1 | end_d2,
                      value | end_d1 | end_d2,
                      c0 | end_d1 | knot_c1,
                      value | end_d1 | knot_c1,
                      c0 | end_d1 | knot_d1,
                      value | end_d1 | knot_d1,
                      c0 | end_d1 | knot_c1 | end_d2,
                      value | end_d1 | knot_c1 | end_d2,
                      c0 | end_d1 | knot_d1 | end_d2,
                      c0 | end_d1 | knot_c1 | knot_c2,
                      value | end_d1 | knot_c1 | knot_c2,
                      c0 | end_d1 | knot_c1 | knot_d2,
                      c0 | end_d1 | knot_d1 | knot_c2,
                      c0 | end_d1 | knot_c1 | end_d2 | knot_c2};
}();
/// Returns the options of a configuration by its number.
FitOptions configuration(std::size_t number, std::size_t degree = 3) {
    FitOptions options;
    options.conditions = configurations[number - 1];
    options.degree = degree;
    return options;
}

BezierCurve bezier(double u1, double y1, double u2, double y2, double height = 1) {
    return {{{{0, 0}, {u1, height * y1}, {u2, height * y2}, {1, height}}}};
}
/// The ten test curves.
BezierCurve test_curve(std::size_t c, double height = 1) {
    constexpr std::array<std::array<double, 4>, 10> handles{{{0.65, 1, 0.80, 1},
                                                             {0.20, 1, 0.25, 1},
                                                             {0.80, 1, 0.20, 1},
                                                             {0.40, 0, 0.60, 1},
                                                             {0.85, 0, 0.15, 1},
                                                             {0.20, 1, 0.80, 0},
                                                             {0.80, 1, 0.20, 0},
                                                             {0.20, 1.3, 0.80, 1.3},
                                                             {0.80, 1.3, 0.20, 1.3},
                                                             {0.80, -0.3, 0.20, 1.3}}};
    const auto& h = handles[c];
    return bezier(h[0], h[1], h[2], h[3], height);
}

// ---- tables --------------------------------------------------------------------------------------

using Row = std::vector<double>;

/// f(1), …, f(n).
template <class F>
Row row_of(std::size_t n, const F& f) {
    Row row;
    for (std::size_t i = 1; i <= n; ++i) row.push_back(f(i));
    return row;
}

/// The summaries of all tables, in the order of their construction.
std::vector<std::string> summaries;

/// Prints a table, ours above theirs. Its destructor adds a summary with the largest difference.
class Table {
public:
    Table(std::string name, std::string what, int decimals, bool sampled = false)
        : name_(std::move(name))
        , decimals_(decimals)
        , sampled_(sampled)
        , number_(summaries.size()) {
        summaries.emplace_back();
        std::printf("\n== %s: %s\n", name_.c_str(), what.c_str());
    }
    Table(const Table&) = delete;
    Table& operator=(const Table&) = delete;
    ~Table() { summaries[number_] = summary(); }
    template <class Theirs>
    void row(const std::string& label, const Row& ours, const Theirs& theirs) {
        std::printf("%-14s", label.c_str());
        for (const double x : ours) std::printf(" %10.*f", decimals_, x);
        std::printf("\n%-14s", "");
        for (const double x : theirs) std::printf(" %10.*f", decimals_, x);
        std::printf("\n");
        for (std::size_t i = 0; i < ours.size(); ++i, ++count_) {
            const double d = std::fabs(ours[i] - theirs[i]);
            if (d <= largest_) continue;
            largest_ = d;
            where_ = label + ", column " + std::to_string(i + 1);
        }
    }

private:
    /// "8.2.1   70 numbers   largest difference 5.0e-07 (half a last digit: 5e-07)".
    std::string summary() const {
        std::array<char, 200> text{};
        const double half = 0.5 * std::pow(10.0, -decimals_);
        std::snprintf(text.data(), text.size(), "%-22s %4zu numbers, largest difference %8.2e %s",
                      name_.c_str(), count_, largest_,
                      sampled_                   ? "(another sample)"
                      : largest_ <= 1.001 * half ? "(all digits)"
                                                 : "");
        std::string result = text.data();
        if (!sampled_ && largest_ > 1.001 * half) result += "(" + where_ + ")";
        return result;
    }

    std::string name_;
    int decimals_;
    bool sampled_;
    std::size_t number_;
    double largest_ = 0;
    std::size_t count_ = 0;
    std::string where_;
};

std::string curve_name(std::size_t c) {
    return "F" + std::to_string(c + 1);
}

/// The W12 error of a fit; ends the program if the fit fails.
double error_at(const BezierCurve& curve, const std::vector<double>& parameters, const FitOptions& options) {
    const auto fit = fit_pieces(curve, parameters, options);
    if (!fit) throw std::runtime_error(cageform::to_string(fit.status()));
    return fit.report.w12_error();
}
/// Fits at the best knots among candidates.
double searched_error(const BezierCurve& curve, const std::vector<double>& candidates, std::size_t pieces,
                      const FitOptions& options) {
    const auto search = search_knots(curve, candidates, pieces, {options});
    if (!search) throw std::runtime_error(cageform::to_string(search.status()));
    return error_at(curve, search.value.parameters, options);
}

double median(Row values) {
    std::nth_element(values.begin(), values.begin() + long(values.size() / 2), values.end());
    return values[values.size() / 2];
}
double share_below(const Row& values, double limit) {
    return 100 * double(std::count_if(values.begin(), values.end(), [&](double v) { return v < limit; })) /
           double(values.size());
}

/// SplitMix64, as the tests' random numbers.
class Random {
public:
    double uniform() {
        std::uint64_t z = (state_ += 0x9E3779B97F4A7C15u);
        z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
        z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
        return double((z ^ (z >> 31)) >> 11) * 0x1p-53;
    }
    std::size_t below(std::size_t n) { return std::size_t(uniform() * double(n)); }

private:
    std::uint64_t state_ = 1;
};

/// The W12 error of the natural cubic spline through a curve's points, for an interval of length 1.
double natural_spline_error(const BezierCurve& curve, const std::vector<double>& parameters) {
    const cageform::SobolevFitter fitter(curve, configuration(3));
    const std::size_t n = parameters.size() - 1;
    std::vector<cageform::SobolevFitter::Piece> pieces;
    for (std::size_t i = 0; i < n; ++i) pieces.push_back(fitter.fit_piece(parameters[i], parameters[i + 1]));
    // Second derivatives m at the knots; 0 at the keys.
    const auto h = [&](std::size_t i) { return pieces[i].x_end - pieces[i].x_begin; };
    const auto y = [&](std::size_t i) {
        return i < n ? pieces[i].polynomial.c[0] : pieces[n - 1].polynomial.c[3];
    };
    Eigen::MatrixXd a = Eigen::MatrixXd::Identity(long(n + 1), long(n + 1));
    Eigen::VectorXd right = Eigen::VectorXd::Zero(long(n + 1));
    for (std::size_t i = 1; i < n; ++i) {
        const long k = long(i);
        a(k, k - 1) = h(i - 1);
        a(k, k) = 2 * (h(i - 1) + h(i));
        a(k, k + 1) = h(i);
        right(k) = 6 * ((y(i + 1) - y(i)) / h(i) - (y(i) - y(i - 1)) / h(i - 1));
    }
    const Eigen::VectorXd m = a.partialPivLu().solve(right);
    double sum = 0;
    for (std::size_t i = 0; i < n; ++i) {
        const double d = h(i), begin = y(i), end = y(i + 1), mb = m(long(i)), me = m(long(i) + 1);
        auto& c = pieces[i].polynomial.c;
        c[1] = (2 * begin + end) / 3 - d * d * (2 * mb + me) / 18;
        c[2] = (begin + 2 * end) / 3 - d * d * (mb + 2 * me) / 18;
        c[0] = begin;
        c[3] = end;
        sum += fitter.cost(pieces[i]);
    }
    return std::sqrt(fitter.in_units(sum));
}

void captions_and_sup_errors() {
    const auto candidates = uniform_in_parameter(30);
    Table errors("Figs 5.7-5.16", "W12 errors, values times 10, K = 30 steps of t, 1 ... 6 pieces", 6);
    std::array<Row, 10> w12, sup;
    for (std::size_t c = 0; c < 10; ++c) {
        for (std::size_t n = 1; n <= 8; ++n) {
            const auto curve = test_curve(c, 10);
            const auto fit =
                fit_pieces(curve, search_knots(curve, candidates, n, {configuration(2)}).value.parameters,
                           configuration(2));
            w12[c].push_back(fit.report.w12_error());
            sup[c].push_back(fit.report.sup_error / 10);
        }
        errors.row(curve_name(c), Row(w12[c].begin(), w12[c].begin() + 6), captions[c]);
    }
    Table largest("8.1 sup errors", "of the same fits, values as they are, 1 ... 8 pieces", 6);
    for (std::size_t c = 0; c < 10; ++c) largest.row(curve_name(c), sup[c], sup_errors[c]);
    Table needed("8.1 pieces needed", "sup <= 1/256, 0.0011598, 1/1920; W12 <= 0.125, 0.0125", 0);
    for (std::size_t c = 0; c < 10; ++c) {
        Row row;
        const auto first_below = [&](const Row& all, double limit) {
            const auto at = std::find_if(all.begin(), all.end(), [&](double e) { return e <= limit; });
            row.push_back(double(at - all.begin()) + 1);
        };
        for (const double limit : {1.0 / 256, 0.0011598, 1.0 / 1920}) first_below(sup[c], limit);
        for (const double limit : {1.25, 0.125}) first_below(w12[c], limit); // values are times 10
        needed.row(curve_name(c), row, pieces_needed[c]);
    }
}

void knots() {
    const auto rows = [](Table& table, std::size_t n, const auto& theirs, const auto& parameters) {
        for (std::size_t c = 0; c < 10; ++c) {
            const auto error = [&](std::size_t pieces) {
                return error_at(test_curve(c), parameters(test_curve(c), pieces), configuration(2));
            };
            table.row(curve_name(c), row_of(n, error), theirs[c]);
        }
    };
    Table by_time("8.2.1", "uniform in time, 1 ... 7 pieces", 6);
    rows(by_time, 7, uniform_time, uniform_in_time);
    Table by_parameter("8.2.2", "uniform in the parameter, 1 ... 7 pieces", 6);
    rows(by_parameter, 7, uniform_parameter,
         [](const BezierCurve&, std::size_t n) { return uniform_in_parameter(n); });
    Table brute("8.2.3", "brute force, error against K, F1 ... F10", 5);
    for (const auto& theirs : brute_force) {
        const auto pieces = std::size_t(theirs[0]), steps = std::size_t(theirs[2]);
        Row row;
        for (std::size_t c = 0; c < 10; ++c) {
            const auto candidates =
                theirs[1] == 0 ? uniform_in_time(test_curve(c), steps) : uniform_in_parameter(steps);
            row.push_back(searched_error(test_curve(c), candidates, pieces, configuration(2)));
        }
        brute.row("N " + std::to_string(pieces) + (theirs[1] == 0 ? ", x, K " : ", t, K ") +
                      std::to_string(steps),
                  row, std::span(theirs).subspan(3));
    }
    Table ratio("8.2.4", "uniform t over brute force in t, F1 ... F10", 2);
    for (const auto& theirs : uniform_over_brute) {
        const auto steps = std::size_t(theirs[0]), pieces = std::size_t(theirs[1]);
        Row row;
        for (std::size_t c = 0; c < 10; ++c)
            row.push_back(
                error_at(test_curve(c), uniform_in_parameter(pieces), configuration(2)) /
                searched_error(test_curve(c), uniform_in_parameter(steps), pieces, configuration(2)));
        ratio.row("K " + std::to_string(steps) + ", N " + std::to_string(pieces), row,
                  std::span(theirs).subspan(2));
    }
    Table best("8.2.5", "optimal knots, 1 ... 6 pieces", 6);
    rows(best, 6, optimum, [](const BezierCurve& curve, std::size_t n) {
        return cageform::optimal_knots(curve, n, {configuration(2)}).value.parameters;
    });
}

void conditions() {
    const auto candidates = uniform_in_parameter(20);
    Row base;
    for (std::size_t c = 0; c < 10; ++c)
        base.push_back(searched_error(test_curve(c), candidates, 3, configuration(1)));
    Table absolute("Table 6.1, base", "3 pieces, K = 20 steps of t, no condition, F1 ... F10", 6);
    absolute.row("I", base, conditions_base[0]);
    Table percent("Table 6.1", "increase over the base in percent, F1 ... F10", 1);
    for (std::size_t n = 2; n <= 27; ++n) {
        Row row;
        for (std::size_t c = 0; c < 10; ++c)
            row.push_back(100 *
                          (searched_error(test_curve(c), candidates, 3, configuration(n)) / base[c] - 1));
        percent.row(roman[n - 1], row, conditions_percent[n - 2]);
    }
}

void w12_against_sup() {
    // A random sample of the source's set of seven million.
    Row all;
    std::array<Row, 6> by_pieces;
    std::array<Row, 4> by_conditions;
    constexpr std::array<std::size_t, 4> numbers{2, 4, 8, 16};
    Row ys;
    for (int i = -10; i < 0; ++i) ys.push_back(0.1 * i);
    for (int i = 0; i < 20; ++i) ys.push_back(0.05 * i);
    for (int i = 10; i <= 20; ++i) ys.push_back(0.1 * i);
    Random random;
    while (all.size() < 29164) {
        const auto x = [&] { return 0.1 + 0.05 * double(random.below(17)); };
        const auto y = [&] { return ys[random.below(ys.size())]; };
        const double u1 = x(), y1 = y(), u2 = x(), y2 = y();
        const std::size_t pieces = 1 + random.below(6), which = random.below(4);
        const auto fit =
            fit_pieces(bezier(u1, y1, u2, y2), uniform_in_parameter(pieces), configuration(numbers[which]));
        if (!fit || fit.report.sup_error < 1e-12) continue; // a straight line
        const double ratio = fit.report.w12_error() / fit.report.sup_error;
        all.push_back(ratio);
        by_pieces[pieces - 1].push_back(ratio);
        by_conditions[which].push_back(ratio);
    }
    std::sort(all.begin(), all.end());
    double mean = 0;
    for (const double r : all) mean += r / double(all.size());
    Table table("8.4", "W12 over sup: least, median, mean, 95 %, largest, share above 20", 2, true);
    table.row(
        "all",
        {all.front(), median(all), mean, all[all.size() * 95 / 100], all.back(), 100 - share_below(all, 20)},
        Row{2.30, 11.0, 12.5, 25.8, 42.0, 15});
    constexpr std::array<std::array<double, 3>, 6> theirs{{{2.3, 5.7, 11.2},
                                                           {3.4, 8.4, 17.4},
                                                           {4.0, 11.5, 26.1},
                                                           {4.8, 14.0, 29.3},
                                                           {5.4, 16.7, 35.2},
                                                           {6.2, 19.0, 42.0}}};
    for (std::size_t n = 0; n < 6; ++n) {
        const auto [least, most] = std::minmax_element(by_pieces[n].begin(), by_pieces[n].end());
        table.row("N " + std::to_string(n + 1), {*least, median(by_pieces[n]), *most}, theirs[n]);
    }
    Row medians;
    for (const Row& values : by_conditions) medians.push_back(median(values));
    table.row("II IV VIII XVI", medians, Row{16.6, 15.1, 9.3, 7.2});
}

void inner_and_outer() {
    constexpr std::array<std::array<double, 2>, 4> outer{
        {{1. / 3, 2. / 3}, {1. / 6, 1. / 2}, {0, 1}, {-0.5, 1.5}}};
    const auto candidates = uniform_in_parameter(20);
    constexpr std::array<std::array<double, 2>, 5> their_shares{
        {{90.9, 92.0}, {89.9, 91.7}, {81.8, 85.0}, {72.7, 75.7}, {83.8, 86.1}}};
    Table shares("8.5", "inner functions: percent with W12 < 0.1, handles in steps of 0.1 and 0.05", 1);
    std::array<Row, 2> all;
    Row medians;
    for (std::size_t o = 0; o < 4; ++o) {
        Row row;
        for (const std::size_t steps : {10u, 20u}) {
            Row errors;
            for (std::size_t i = 0; i <= steps; ++i) {
                for (std::size_t j = 0; j <= steps; ++j) {
                    const double n = double(steps);
                    const auto curve = bezier(double(i) / n, outer[o][0], double(j) / n, outer[o][1]);
                    if (cageform::check(curve).vertical_tangent) continue;
                    errors.push_back(searched_error(curve, candidates, 3, configuration(2)));
                }
            }
            row.push_back(share_below(errors, 0.1));
            if (steps == 10) medians.push_back(median(errors));
            auto& sum = all[steps == 10 ? 0 : 1];
            sum.insert(sum.end(), errors.begin(), errors.end());
        }
        shares.row("outer " + std::to_string(o + 1), row, their_shares[o]);
    }
    shares.row("all", {share_below(all[0], 0.1), share_below(all[1], 0.1)}, their_shares[4]);
    Table middles("8.5 medians", "steps of 0.1, outer 1 ... 4", 4);
    middles.row("", medians, Row{0.0154, 0.0176, 0.0228, 0.0556});

    Table corners("8.5 corners", "L2 errors, outer (0, 1), K = 10: (0,0), (1,1), (1,0), (0,1)", 6);
    Row row;
    for (const auto& [a, b] : {std::array{0., 0.}, {1., 1.}, {1., 0.}, {0., 1.}}) {
        auto options = configuration(2);
        options.slope_weight = 0;
        const auto curve = bezier(a, 0, b, 1);
        const auto search = search_knots(curve, uniform_in_parameter(10), 3, {options});
        row.push_back(fit_pieces(curve, search.value.parameters, options).report.l2_error);
    }
    corners.row("", row, Row{0.001463, 0.001463, 0.008739, 0});

    constexpr std::array<std::array<double, 2>, 3> inner{
        {{1. / 6, 5. / 6}, {2. / 3, 1. / 3}, {2. / 3, 2. / 3}}};
    constexpr std::array<std::array<double, 2>, 3> found{
        {{0.1511, 0.0672}, {0.1077, 0.0447}, {0.0343, 0.0127}}};
    std::array<Row, 3> errors;
    for (std::size_t k = 0; k < 3; ++k) {
        for (int i = -10; i <= 20; ++i) {
            for (int j = -10; j <= 20; ++j) {
                const auto curve = bezier(inner[k][0], 0.1 * i, inner[k][1], 0.1 * j);
                errors[k].push_back(searched_error(curve, candidates, 3, configuration(2)));
            }
        }
    }
    Table below("8.6", "outer functions: percent with W12 < 0.1, inner 1 ... 3", 1);
    below.row("", {share_below(errors[0], 0.1), share_below(errors[1], 0.1), share_below(errors[2], 0.1)},
              Row{80.3, 99.4, 100});
    Table sizes("8.6 errors", "largest, median", 4);
    for (std::size_t k = 0; k < 3; ++k)
        sizes.row("inner " + std::to_string(k + 1),
                  {*std::max_element(errors[k].begin(), errors[k].end()), median(errors[k])}, found[k]);
}

void degrees_and_splines() {
    Table by_degree("8.7", "degrees 3, 4, 5 of each curve, K = 20 steps of t, 1 ... 4 pieces", 6);
    for (std::size_t r = 0; r < 30; ++r) {
        Row row;
        for (std::size_t n = 1; n <= 4; ++n)
            row.push_back(
                searched_error(test_curve(r / 3), uniform_in_parameter(20), n, configuration(3, 3 + r % 3)));
        by_degree.row(curve_name(r / 3) + ", degree " + std::to_string(3 + r % 3), row, degrees[r]);
    }
    for (const bool in_time : {true, false}) {
        Table ratio(in_time ? "8.8 uniform in time" : "8.8 uniform in t",
                    "clamped spline over IX, over II, 1 ... 8 pieces", 2);
        for (std::size_t r = 0; r < 20; ++r) {
            Row row;
            const auto curve = test_curve(r / 2);
            for (std::size_t n = 1; n <= 8; ++n) {
                const auto t = in_time ? uniform_in_time(curve, n) : uniform_in_parameter(n);
                row.push_back(error_at(curve, t, configuration(24)) /
                              error_at(curve, t, configuration(r % 2 == 0 ? 9 : 2)));
            }
            ratio.row(curve_name(r / 2) + (r % 2 == 0 ? ", IX" : ", II"), row,
                      (in_time ? spline_ratio_time : spline_ratio_parameter)[r]);
        }
    }
    Table absolute("8.8 errors", "clamped, natural, IX, II, uniform in t, 1 ... 8 pieces", 6);
    constexpr std::array<const char*, 4> methods{"clamped", "natural", "IX", "II"};
    for (std::size_t r = 0; r < 40; ++r) {
        Row row;
        const auto curve = test_curve(r / 4);
        for (std::size_t n = 1; n <= 8; ++n) {
            const auto t = uniform_in_parameter(n);
            row.push_back(r % 4 == 1 ? natural_spline_error(curve, t)
                                     : error_at(curve, t,
                                                configuration(r % 4 == 0   ? 24
                                                              : r % 4 == 2 ? 9
                                                                           : 2)));
        }
        absolute.row(curve_name(r / 4) + ", " + methods[r % 4], row, spline_errors[r]);
    }
}

void scale_and_memory() {
    constexpr std::array<double, 10> lengths{0.1, 0.25, 0.5, 2, 5, 10, 20, 50, 100, 1000};
    constexpr std::array<std::array<double, 10>, 2> theirs{
        {{3.16, 2, 1.414, 0.708, 0.45, 0.33, 0.26, 0.22, 0.25, 0.71},
         {3.16, 2, 1.414, 0.708, 0.45, 0.33, 0.26, 0.26, 0.32, 0.93}}};
    Table scale("8.9",
                "W12 error in units over that of length 1, least and most of F1 ... F10 (theirs: of six "
                "curves), T = 0.1 ... 1000",
                3, true);
    Row least(10, 1e9), most(10, 0);
    for (std::size_t c = 0; c < 10; ++c) {
        for (std::size_t k = 0; k < 10; ++k) {
            auto options = configuration(2);
            options.scale_free = false;
            auto curve = test_curve(c);
            for (auto& p : curve.points) p[0] *= lengths[k];
            const auto t = uniform_in_parameter(3);
            const double ratio = error_at(curve, t, options) / error_at(test_curve(c), t, configuration(2));
            least[k] = std::min(least[k], ratio);
            most[k] = std::max(most[k], ratio);
        }
    }
    scale.row("least", least, theirs[0]);
    scale.row("most", most, theirs[1]);

    Table memory("8.10",
                 "random curves, degrees 3, 4, 5: mean pieces for 0.0125, size over Bezier's, % over 0.125",
                 2, true);
    constexpr std::array<std::array<double, 2>, 2> ranges{{{0, 1}, {-1, 2}}};
    constexpr std::array<std::array<double, 3>, 2> sizes{{{2.40, 2.14, 2.08}, {2.80, 2.40, 2.26}}};
    for (std::size_t r = 0; r < 2; ++r) {
        Random random;
        std::array<Row, 2> pieces{Row(3, 0), Row(3, 0)};
        constexpr std::size_t curves = 300;
        for (std::size_t k = 0; k < curves; ++k) {
            const auto y = [&] { return ranges[r][0] + (ranges[r][1] - ranges[r][0]) * random.uniform(); };
            const double u1 = random.uniform(), y1 = y(), u2 = random.uniform(), y2 = y();
            const auto curve = bezier(u1, y1, u2, y2);
            for (std::size_t degree = 3; degree <= 5; ++degree) {
                std::size_t n = 1;
                for (std::size_t limit = 0; limit < 2; ++limit) { // 0.125, then 0.0125
                    while (n < 20 && searched_error(curve, uniform_in_parameter(20), n,
                                                    configuration(3, degree)) > (limit == 0 ? 0.125 : 0.0125))
                        ++n;
                    pieces[limit][degree - 3] += double(n) / curves;
                }
            }
        }
        Row size, more;
        for (std::size_t d = 0; d < 3; ++d) {
            const auto values = [&](double n) { return (10 * n * double(d + 5) + 1) / 80; }; // 10 intervals
            size.push_back(values(pieces[1][d]));
            more.push_back(100 * (values(pieces[1][d]) / values(pieces[0][d]) - 1));
        }
        const std::string range = r == 0 ? "y in [0,1]" : "y in [-1,2]";
        if (r == 0) memory.row(range, pieces[1], Row{3.83, 2.84, 2.36});
        memory.row(range + ", x", size, sizes[r]);
        std::printf("%-14s", "  % over 0.125");
        for (const double m : more) std::printf(" %10.0f", m);
        std::printf("   theirs: 52 to 107\n");
    }
}

int run_program(int argc, char** argv) {
    cageform_support::CommandLine options("Prints tables of fits of Bezier curves beside known numbers.");
    if (const auto code = options.parse(argc, argv)) return *code;
    const auto start = std::chrono::steady_clock::now();
    captions_and_sup_errors();
    knots();
    conditions();
    w12_against_sup();
    inner_and_outer();
    degrees_and_splines();
    scale_and_memory();
    std::printf("\n== differences from the known numbers\n");
    for (const std::string& line : summaries) std::printf("%s\n", line.c_str());
    std::printf("%.1f s\n", std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    return cageform_support::guarded("bezier_tables", [&] { return run_program(argc, argv); });
}
