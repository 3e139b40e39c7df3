# tinygltf as the target dualpixel_tinygltf: the library where there is one, as in Debian; otherwise its header, as vcpkg and
# Conan bring it, whose code the simulator then holds. Fuzzers want the latter, so that its code is instrumented, too.
option(DUALPIXEL_COMPILE_TINYGLTF "Compile tinygltf's code into the simulator" OFF)
find_package(TinyGLTF QUIET)
if(TARGET TinyGLTF::TinyGLTF)
  get_target_property(tinygltf_type TinyGLTF::TinyGLTF TYPE)
endif()
add_library(dualpixel_tinygltf INTERFACE)
if(tinygltf_type MATCHES "^(SHARED|STATIC|UNKNOWN)_LIBRARY$" AND NOT DUALPIXEL_COMPILE_TINYGLTF)
  set(tinygltf_is_library ON)
  target_link_libraries(dualpixel_tinygltf INTERFACE TinyGLTF::TinyGLTF)
else()
  set(tinygltf_is_library OFF)
  if(TARGET TinyGLTF::TinyGLTF)
    get_target_property(tinygltf_folders TinyGLTF::TinyGLTF INTERFACE_INCLUDE_DIRECTORIES)
  endif()
  find_path(TINYGLTF_HEADERS tiny_gltf.h HINTS ${tinygltf_folders} REQUIRED)
  target_include_directories(dualpixel_tinygltf SYSTEM INTERFACE ${TINYGLTF_HEADERS})
  # OpenImageIO reads the textures, and nlohmann_json's header is a package of its own.
  target_compile_definitions(dualpixel_tinygltf INTERFACE DUALPIXEL_COMPILE_TINYGLTF TINYGLTF_NO_STB_IMAGE
                                                          TINYGLTF_NO_STB_IMAGE_WRITE TINYGLTF_NO_INCLUDE_JSON)
endif()
