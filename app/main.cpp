#include <csignal>

#include "app/cli/cli.h"
#include "core/system/freed_memory.h"

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a file size limit is a write error then, like a full disk
  scanknit::keep_freed_memory();
  return scanknit::run_cli(argc, argv);
}
