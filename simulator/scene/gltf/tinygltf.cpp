// tinygltf's code, where it comes as a header alone (cmake/find_tinygltf.cmake).
#ifdef DUALPIXEL_COMPILE_TINYGLTF
#include <nlohmann/json.hpp>

#define TINYGLTF_IMPLEMENTATION
#include <tiny_gltf.h>
#endif
