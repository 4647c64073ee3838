# SPDX-License-Identifier: Apache-2.0
# Writes a file's 32-bit words (little-endian) as a C++ initialiser list: cmake -DIN=... -DOUT=... -P EmbedWords.cmake.
file(READ ${IN} bytes HEX)
string(REGEX REPLACE "(..)(..)(..)(..)" "0x\\4\\3\\2\\1," words "${bytes}")
string(REGEX REPLACE "(0x........,0x........,0x........,0x........,0x........,0x........,0x........,0x........,)" "\\1\n" words "${words}")
file(WRITE ${OUT} "${words}\n")
