# What people are found with: oneDNN (libdnnl-dev) as dualpixel_onednn, dlib (libdlib-dev, and liblapack-dev, which its
# headers use) as dualpixel_dlib; no target where one is not installed or not asked for by DUALPIXEL_ONEDNN and
# DUALPIXEL_DLIB. Their own CMake packages are not used: they ask for OpenCL and for much else that we do not need.
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
if(DUALPIXEL_DLIB AND NOT TARGET dualpixel_dlib)
  find_path(DUALPIXEL_DLIB_HEADERS dlib/image_processing/frontal_face_detector.h)
  find_library(DUALPIXEL_DLIB_LIBRARY dlib)
  find_library(DUALPIXEL_LAPACK_LIBRARY lapack)
  if(DUALPIXEL_DLIB_HEADERS AND DUALPIXEL_DLIB_LIBRARY AND DUALPIXEL_LAPACK_LIBRARY)
    add_library(dualpixel_dlib UNKNOWN IMPORTED GLOBAL)
    set_target_properties(dualpixel_dlib PROPERTIES IMPORTED_LOCATION ${DUALPIXEL_DLIB_LIBRARY}
                          INTERFACE_INCLUDE_DIRECTORIES ${DUALPIXEL_DLIB_HEADERS}
                          INTERFACE_LINK_LIBRARIES ${DUALPIXEL_LAPACK_LIBRARY})
  endif()
endif()
