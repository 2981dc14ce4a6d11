# Toolchain for 64-bit ARM under Linux: Debian's cross compiler, and qemu to run what it has built.
#   apt-get install -y g++-aarch64-linux-gnu qemu-user-static
#   cmake --workflow --preset aarch64         or, of the library alone:
#   cmake -S . -B build/board -DCMAKE_TOOLCHAIN_FILE=cpp/aarch64-linux-gnu.cmake
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)

find_program(ASAP_CROSS_COMPILER aarch64-linux-gnu-g++)
if(NOT ASAP_CROSS_COMPILER)
  message(FATAL_ERROR "aarch64-linux-gnu-g++ is missing: apt-get install -y g++-aarch64-linux-gnu")
endif()
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)  # GoogleTest asks for one
set(CMAKE_CXX_COMPILER "${ASAP_CROSS_COMPILER}")

find_program(ASAP_EMULATOR qemu-aarch64-static)
if(ASAP_EMULATOR)
  set(CMAKE_CROSSCOMPILING_EMULATOR "${ASAP_EMULATOR};-L;/usr/aarch64-linux-gnu")
endif()
