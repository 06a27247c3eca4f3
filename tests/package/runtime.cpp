#include <cageform/runtime.hpp>

int main() {
    return int(cageform::BindingView<double, 2>{}.point_count());
}
