# Writes the manual page and the completions of each of these PROGRAMS into the folder SHARE, as the
# programs themselves print them.
function(write_text program option file)
  execute_process(COMMAND ${program} ${option} OUTPUT_FILE ${SHARE}/${file} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(REMOVE_RECURSE ${SHARE})
file(MAKE_DIRECTORY ${SHARE}/man/man1 ${SHARE}/bash-completion/completions)
foreach(program ${PROGRAMS})
  get_filename_component(name ${program} NAME)
  write_text(${program} --man-page man/man1/${name}.1)
  write_text(${program} --completion=bash bash-completion/completions/${name})
  execute_process(COMMAND gzip -9n ${SHARE}/man/man1/${name}.1 COMMAND_ERROR_IS_FATAL ANY)
endforeach()
