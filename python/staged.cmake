# Puts the compiled part of the package, which lies in the folder PALPATE_PYTHON_STAGED as `cmake --install` left it, into a wheel.
if(NOT EXISTS ${PALPATE_PYTHON_STAGED}/palpate)
  message(FATAL_ERROR "there is no installed package in ${PALPATE_PYTHON_STAGED}")
endif()
install(DIRECTORY ${PALPATE_PYTHON_STAGED}/palpate DESTINATION . USE_SOURCE_PERMISSIONS COMPONENT python)
install(PROGRAMS ${CMAKE_CURRENT_LIST_DIR}/command/palpate DESTINATION ${SKBUILD_SCRIPTS_DIR} COMPONENT python)
foreach(target palpate_python palpate_python_stub palpate_command)
  add_custom_target(${target})
endforeach()
