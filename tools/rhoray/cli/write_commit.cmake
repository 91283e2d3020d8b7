# Writes OUTPUT with the commit of SOURCE_DIR, touching the file only when the commit has changed.
execute_process(COMMAND git -C ${SOURCE_DIR} describe --always --dirty=+ --abbrev=12
                OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE trouble)
if(trouble)
  set(commit unknown)
endif()
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT "#pragma once\n#define RHORAY_COMMIT \"${commit}\"\n")
