# OpenImageIO, without the folder of OpenCV headers that Debian's target names although its package does not bring it.
find_package(OpenImageIO REQUIRED)
foreach(property INTERFACE_INCLUDE_DIRECTORIES INTERFACE_SYSTEM_INCLUDE_DIRECTORIES)
  get_target_property(folders OpenImageIO::OpenImageIO ${property})
  if(folders)
    list(FILTER folders EXCLUDE REGEX "opencv")
    set_target_properties(OpenImageIO::OpenImageIO PROPERTIES ${property} "${folders}")
  endif()
endforeach()
