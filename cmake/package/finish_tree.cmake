# Run by cpack before it packs: what Debian asks of the files of a package.
file(GLOB components LIST_DIRECTORIES true ${CPACK_TEMPORARY_DIRECTORY}/*)
foreach(component IN LISTS components)
  # Manual pages and changelogs are compressed, without a name or a time.
  file(GLOB_RECURSE texts ${component}/usr/share/man/*.1 ${component}/usr/share/doc/*/changelog)
  foreach(text IN LISTS texts)
    execute_process(COMMAND gzip -9nf ${text} COMMAND_ERROR_IS_FATAL ANY)
  endforeach()
  # The libraries lie where the system looks.
  file(GLOB binaries ${component}/usr/bin/* ${component}/usr/lib/*.so* ${component}/usr/lib/*/*.so*
       ${component}/usr/lib/*/scanknit/*.so
       ${component}/usr/lib/python3/dist-packages/scanknit/*.so)
  foreach(binary IN LISTS binaries)
    if(NOT IS_SYMLINK ${binary})
      file(RPATH_REMOVE FILE ${binary})
      file(CHMOD ${binary} PERMISSIONS OWNER_READ OWNER_WRITE GROUP_READ WORLD_READ)
    endif()
  endforeach()
  file(GLOB programs ${component}/usr/bin/*)
  foreach(program IN LISTS programs)
    file(CHMOD ${program} PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
  endforeach()
endforeach()
