// A library that is no module.
extern "C" __attribute__((visibility("default"))) int scanknit_another_function() {
  return 1;
}
