# Installs the build tree BUILD to a fresh folder, then configures, builds and runs the consumer against it.
set(prefix ${BUILD}/consumer/installed)
set(build ${BUILD}/consumer/build)
set(configure -S ${SOURCE} -B ${build} -G ${GENERATOR} -DCMAKE_PREFIX_PATH=${prefix} -DCMAKE_CXX_COMPILER=${CXX})
if(SANITIZE)
  list(APPEND configure -DCMAKE_CXX_FLAGS=-fsanitize=${SANITIZE})
endif()

function(run)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${ARGV}: ${status}\n${output}")
  endif()
endfunction()

file(REMOVE_RECURSE ${BUILD}/consumer)
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${prefix})
run(${CMAKE_COMMAND} ${configure})
run(${CMAKE_COMMAND} --build ${build})
run(${build}/consumer ${prefix}/share/dualpixel/scenes/slanted_planes.json)
run(${prefix}/bin/dualpixel --version)
# The shipped scenes come with the lenses that they name; internal headers do not come.
run(${prefix}/bin/dualpixel simulate ${prefix}/share/dualpixel/scenes/portrait.json -o ${BUILD}/consumer/capture --dry-run)
foreach(internal capture/lanes.h pipeline/burst/fft16.h pipeline/edge_aware/bilateral_grid.h simulator/lens/lens_packet.h
        simulator/render/intersector.h simulator/sampling/packet.h simulator/sampling/sobol.h)
  if(EXISTS ${prefix}/include/dualpixel/${internal})
    message(FATAL_ERROR "${internal}, an internal header, was installed")
  endif()
endforeach()
