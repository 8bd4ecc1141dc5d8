# Lets the program write its manual pages and completions.
#   cmake -D PROGRAM=... -D VERBS=... -D WORDS=... -P words.cmake
function(write_words file)
  execute_process(COMMAND ${PROGRAM} ${ARGN} OUTPUT_FILE ${WORDS}/${file} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(REMOVE_RECURSE ${WORDS})
file(MAKE_DIRECTORY ${WORDS}/man1 ${WORDS}/completions)
write_words(man1/marquetry.1 --manual)
foreach(verb ${VERBS})
  write_words(man1/marquetry-${verb}.1 --manual ${verb})
endforeach()
write_words(completions/marquetry --completion bash)
write_words(completions/_marquetry --completion zsh)
write_words(completions/marquetry.fish --completion fish)
file(TOUCH ${WORDS}/made)
