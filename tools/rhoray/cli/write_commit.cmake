# Writes OUTPUT with COMMIT, or if that is empty the commit of SOURCE_DIR. Touches the file only
# when it has changed.
if(NOT COMMIT)
  execute_process(COMMAND git -C ${SOURCE_DIR} describe --always --dirty=+ --abbrev=12
                  OUTPUT_VARIABLE COMMIT OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE trouble)
  if(trouble)
    set(COMMIT unknown)
  endif()
endif()
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT "#pragma once\n#define RHORAY_COMMIT \"${COMMIT}\"\n")
