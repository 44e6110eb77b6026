# run(COMMAND...): ends the test with what a command says where it fails; its output is in `output`.
function(run)
  execute_process(COMMAND ${ARGN} OUTPUT_VARIABLE output ERROR_VARIABLE output RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "exit ${result} from: ${command}\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

# The boxes of examples/embed overlap by 0.1 along z and by 0.7 along x and y: 0.1 deep, straight up, but for what the
# planes of the sides add.
function(check_embed output)
  if(NOT output MATCHES "point 8 is 0\\.1[01][0-9] deep in body 0, out: \\(0\\.0[0-9], 0\\.0[0-9], 1\\.00\\)\n")
    message(FATAL_ERROR "embed printed: ${output}")
  endif()
endfunction()
