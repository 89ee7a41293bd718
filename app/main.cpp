#include "app/cli.h"

int main(int argc, char** argv) {
  return scanknit::run_cli(argc, argv);
}
