// What the leak checker of the address sanitizer is told when a program starts: VTK and Teem lose
// memory when they refuse a damaged file. In the worker it ends with the process.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libvtk\nleak:libteem\n";
}
