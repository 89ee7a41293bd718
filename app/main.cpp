#include <csignal>

#include "app/cli/cli.h"
#include "core/freed_memory.h"

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is an error like a full disk, not the end of the program
  scanknit::keep_freed_memory();
  return scanknit::run_cli(argc, argv);
}
