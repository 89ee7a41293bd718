# Renders the sample recording unless it is there, newer than the program, and installs it: scanknit, sample,
# destination (Install.cmake).
if(NOT EXISTS ${sample} OR ${scanknit} IS_NEWER_THAN ${sample})
  get_filename_component(folder ${sample} DIRECTORY)
  file(REMOVE_RECURSE ${folder})
  file(MAKE_DIRECTORY ${folder})
  execute_process(COMMAND ${scanknit} synth turntable --frames 36 --width 320 --height 240 --noise --seed 1 --jpeg
                          -o ${folder}/frames --quiet COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND ${scanknit} convert ${folder}/frames --to mcap -o ${folder}/unfinished.mcap --quiet
                  OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
  file(RENAME ${folder}/unfinished.mcap ${sample})
  file(REMOVE_RECURSE ${folder}/frames)
endif()
file(INSTALL ${sample} DESTINATION ${destination})
