#include "app/cli.h"
#include "core/freed_memory.h"

int main(int argc, char** argv) {
  scanknit::keep_freed_memory();
  return scanknit::run_cli(argc, argv);
}
