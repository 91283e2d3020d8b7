// The leak checker of the address sanitizer reads this list when a program starts. VTK and Teem do
// not free memory when they refuse a damaged file. In the worker, the end of the process frees it.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libvtk\nleak:libteem\n";
}
