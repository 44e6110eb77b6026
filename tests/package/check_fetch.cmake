# Configures, and with BUILD builds and runs, a program that has Palpate by FetchContent.
cmake_minimum_required(VERSION 3.25)
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

file(REMOVE_RECURSE "${WORK_DIR}")
file(COPY "${CMAKE_CURRENT_LIST_DIR}/fetch/CMakeLists.txt" "${SOURCE_DIR}/examples/embed/main.cpp" DESTINATION "${WORK_DIR}/source")
run(${CMAKE_COMMAND} -S "${WORK_DIR}/source" -B "${WORK_DIR}/build" -G "${GENERATOR}" "-DCMAKE_CXX_COMPILER=${CXX}"
    -DCMAKE_BUILD_TYPE=Release "-DFETCHCONTENT_SOURCE_DIR_PALPATE=${SOURCE_DIR}" ${FLAGS})
# Only the library: no tools, no tests, and nothing of ours in the other's `cmake --install`.
run(${CMAKE_COMMAND} --build "${WORK_DIR}/build" --target help)
foreach(target IN ITEMS palpate_command palpate_io test_sim)
  if(output MATCHES "[^a-z_]${target}:")
    message(FATAL_ERROR "the other's build has our target ${target}")
  endif()
endforeach()
run(${CMAKE_COMMAND} --install "${WORK_DIR}/build" --prefix "${WORK_DIR}/prefix")
if(EXISTS "${WORK_DIR}/prefix/include")
  message(FATAL_ERROR "the other's install has our files")
endif()
if(BUILD)
  run(${CMAKE_COMMAND} --build "${WORK_DIR}/build")
  run("${WORK_DIR}/build/embed")
  check_embed("${output}")
endif()
