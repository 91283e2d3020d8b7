// The leak checker of the address sanitizer reads this list when a program starts. VTK and Teem do
// not free memory when they refuse a damaged file. In the worker, the end of the process frees it.
// Gmsh's library keeps tables of element types until the process ends.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libvtk\nleak:libteem\nleak:libgmsh\n";
}
