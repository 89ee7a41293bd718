# For tests: -DSCANKNIT_SANITIZE=address,undefined, or what else -fsanitize= takes.
add_compile_options(-fsanitize=${SCANKNIT_SANITIZE} -fno-omit-frame-pointer)
add_link_options(-fsanitize=${SCANKNIT_SANITIZE})
# Asio has fences, which this sanitizer does not see; what is behind them it sees by the locks beside them.
add_compile_options($<$<CXX_COMPILER_ID:GNU>:-Wno-tsan>)
if(SCANKNIT_BUILD_PYTHON STREQUAL "AUTO")
  set(SCANKNIT_BUILD_PYTHON OFF)  # the interpreter knows nothing of sanitizers
endif()
