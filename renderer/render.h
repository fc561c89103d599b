#pragma once
#include <string>
namespace ohb {
std::string ray_library_version();
}
