# What people and faces are found with: oneDNN (libdnnl-dev) as dualpixel_onednn; no target where it is not installed or
# not asked for by DUALPIXEL_ONEDNN. Its own CMake package is not used: it asks for OpenCL, which we do not need.
if(DUALPIXEL_ONEDNN AND NOT TARGET dualpixel_onednn)
  find_path(DUALPIXEL_ONEDNN_HEADERS oneapi/dnnl/dnnl.hpp)
  find_library(DUALPIXEL_ONEDNN_LIBRARY dnnl)
  if(DUALPIXEL_ONEDNN_HEADERS AND DUALPIXEL_ONEDNN_LIBRARY)
    set(dualpixel_onednn_version "unknown")
    if(EXISTS ${DUALPIXEL_ONEDNN_HEADERS}/oneapi/dnnl/dnnl_version.h)
      file(STRINGS ${DUALPIXEL_ONEDNN_HEADERS}/oneapi/dnnl/dnnl_version.h dualpixel_onednn_version
           REGEX "define DNNL_VERSION_MAJOR")
      string(REGEX MATCH "[0-9]+" dualpixel_onednn_version "${dualpixel_onednn_version}")
    endif()
    if(dualpixel_onednn_version MATCHES "^[23]$")
      add_library(dualpixel_onednn UNKNOWN IMPORTED GLOBAL)
      set_target_properties(dualpixel_onednn PROPERTIES IMPORTED_LOCATION ${DUALPIXEL_ONEDNN_LIBRARY}
                            INTERFACE_INCLUDE_DIRECTORIES ${DUALPIXEL_ONEDNN_HEADERS}
                            INTERFACE_LINK_LIBRARIES gomp)  # its threads are OpenMP's
    else()
      message(STATUS "oneDNN ${dualpixel_onednn_version} found: dualpixel is written for versions 2 and 3")
    endif()
  endif()
endif()
