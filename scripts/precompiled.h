// What most files include, parsed once for all of them (Makefile: precompiled). No file may rely on it: builds under sanitizers, of library and programs, go without.
#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>
