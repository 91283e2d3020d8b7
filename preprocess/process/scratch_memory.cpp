#include "preprocess/process/scratch_memory.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "formats/base/error.h"
#include "preprocess/process/nameless_file.h"

namespace rhoray::preprocess {

void* ScratchMemory::do_allocate(std::size_t bytes, std::size_t alignment) {
  if (bytes < smallest_block) return std::pmr::new_delete_resource()->allocate(bytes, alignment);
  const int descriptor = open_nameless_file(folder_, bytes);
  void* block = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
  const int error = errno;
  ::close(descriptor);  // the mapping keeps the file
  if (block != MAP_FAILED) return block;
  throw Error(ErrorCode::resource,
              concat(folder_.string(), ": cannot map a scratch file of ", bytes, " bytes: ", std::strerror(error)));
}

void ScratchMemory::do_deallocate(void* block, std::size_t bytes, std::size_t alignment) {
  if (bytes < smallest_block)
    std::pmr::new_delete_resource()->deallocate(block, bytes, alignment);
  else
    ::munmap(block, bytes);
}

}  // namespace rhoray::preprocess
