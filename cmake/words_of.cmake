# SPDX-License-Identifier: Apache-2.0
# cmake -DBINARY=file.spv -DWORDS=file.inc -P words_of.cmake: little-endian words of 32 bits as C++ literals.
file(READ "${BINARY}" digits HEX)
string(REGEX REPLACE "(..)(..)(..)(..)" "0x\\4\\3\\2\\1,\n" words "${digits}")
file(WRITE "${WORDS}" "${words}")
