# LibRaw as the target dualpixel_libraw: Debian's package brings no CMake files.
if(NOT TARGET dualpixel_libraw)
  find_path(DUALPIXEL_LIBRAW_HEADERS libraw/libraw.h REQUIRED)
  find_library(DUALPIXEL_LIBRAW_LIBRARY raw_r REQUIRED)  # the variant for threads
  add_library(dualpixel_libraw UNKNOWN IMPORTED GLOBAL)
  set_target_properties(dualpixel_libraw PROPERTIES IMPORTED_LOCATION ${DUALPIXEL_LIBRAW_LIBRARY}
                        INTERFACE_INCLUDE_DIRECTORIES ${DUALPIXEL_LIBRAW_HEADERS})
endif()
