# Settings that every target shares; targets link ohb_settings to get them.
set(CMAKE_CXX_STANDARD 17)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()

find_program(CCACHE ccache)
if(CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE})
endif()

add_library(ohb_settings INTERFACE)
target_include_directories(ohb_settings INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_options(ohb_settings INTERFACE -Wall -Wextra -Wpedantic -Werror)
target_compile_definitions(ohb_settings INTERFACE OHB_VERSION="${PROJECT_VERSION}")
if(OHB_SANITIZE)
  # g++ 12 raises false maybe-uninitialized alarms inside instrumented standard headers.
  target_compile_options(ohb_settings INTERFACE -fsanitize=${OHB_SANITIZE} -fno-omit-frame-pointer
                                                -Wno-maybe-uninitialized)
  # A third of the time to compile: null pointers and sizes of objects the address sanitizer sees too, and the processors
  # that this is for read at any address.
  if(OHB_SANITIZE MATCHES "undefined")
    target_compile_options(ohb_settings INTERFACE -fno-sanitize=null,alignment,object-size)
  endif()
  target_link_options(ohb_settings INTERFACE -fsanitize=${OHB_SANITIZE})
endif()

# For code that only asks others to compute (tests, command lines): a third less to compile.
add_library(ohb_glue_options INTERFACE)
if(OHB_SANITIZE)
  target_compile_options(ohb_glue_options INTERFACE -O0)
else()
  target_compile_options(ohb_glue_options INTERFACE $<$<CONFIG:Release>:-O1>)
endif()
