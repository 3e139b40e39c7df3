# What distributors need: a pkg-config file, manual pages, bash completion, and the Debian package that `cpack` makes.

# Libraries without a pkg-config file, and LibRaw, whose file names flags of its compiler. The libraries of this project are
# static, so programs that link them need these as well.
set(pc_libraries "-lraw_r -lembree${embree_VERSION_MAJOR}")
if(TARGET dualpixel_onednn)
  string(APPEND pc_libraries " -ldnnl -lgomp")
endif()
set(pc_tinygltf)
if(tinygltf_is_library)
  set(pc_tinygltf " tinygltf")
endif()
# From the folder of the file to the prefix, so that the tree may be moved.
file(RELATIVE_PATH pc_prefix /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
configure_file(cmake/dualpixel.pc.in ${PROJECT_BINARY_DIR}/dualpixel.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/dualpixel.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)

# The notices of what is compiled in, as the packages of this system have them.
file(READ ${PROJECT_SOURCE_DIR}/THIRD_PARTY.md notices)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS THIRD_PARTY.md)
foreach(package libcli11-dev libxxhash-dev nlohmann-json3-dev libglm-dev libeigen3-dev libtinygltf-dev)
  if(EXISTS /usr/share/doc/${package}/copyright)
    file(READ /usr/share/doc/${package}/copyright notice)
    string(APPEND notices "\n\n---- ${package} ----\n\n${notice}")
  endif()
endforeach()
file(WRITE ${PROJECT_BINARY_DIR}/copyright "${notices}")
install(FILES ${PROJECT_BINARY_DIR}/copyright DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/dualpixel)

install(FILES tools/completion/dualpixel DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)

# One page for the program and one for each of its commands, made of their --help at the first install.
find_program(HELP2MAN help2man)
if(HELP2MAN)
  set(pages ${PROJECT_BINARY_DIR}/man1)
  install(CODE "message(STATUS \"Manual pages: half a minute, the first time\")
                execute_process(COMMAND \"${PROJECT_SOURCE_DIR}/cmake/manual_pages.sh\" \"$<TARGET_FILE:dualpixel>\"
                                        \"${pages}\" COMMAND_ERROR_IS_FATAL ANY)")
  install(DIRECTORY ${pages} DESTINATION ${CMAKE_INSTALL_MANDIR} FILES_MATCHING PATTERN "*.1")
else()
  message(STATUS "No help2man: no manual pages are installed")
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "The dualpixel maintainers <dualpixel@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "dual-pixel camera simulator and portrait pipeline")
set(CPACK_PACKAGE_DESCRIPTION
    "Renders scenes through a lens onto a dual-pixel sensor, with exact ground truth, and
computes portraits with synthetic depth of field from dual-pixel captures. Holds the
program, its static C++20 libraries with their headers, lens models and scenes.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
# For programs that link the libraries.
set(CPACK_DEBIAN_PACKAGE_SUGGESTS
    "libembree-dev, libopenimageio-dev, openimageio-tools, libopenexr-dev, libtiff-dev, libraw-dev, zlib1g-dev, \
libtinygltf-dev, libglm-dev, libtbb-dev, nlohmann-json3-dev, libfmt-dev, libdnnl-dev")
include(CPack)
