# Of a preprocessed touchable.h: a C program that prints the size of every struct and the offset of every member.
BEGIN {
    print "#include <stddef.h>\n#include <stdio.h>\n#include \"touchable.h\"\nint main(void) {"
}
{
    text = text " " $0
}
END {
    while (match(text, /typedef struct touch_[a-z0-9_]* *\{[^}]*\}/)) {
        one = substr(text, RSTART, RLENGTH)
        text = substr(text, RSTART + RLENGTH)
        sub(/^typedef struct /, "", one)
        name = one
        sub(/ *\{.*/, "", name)
        sub(/^[^{]*\{/, "", one)
        sub(/\}$/, "", one)
        printf "    printf(\"struct %s %%zu\\n\", sizeof(%s));\n", name, name
        count = split(one, members, /[;,]/)
        for (k = 1; k <= count; ++k) {
            member = members[k]
            sub(/\[.*/, "", member)
            if (!match(member, /[a-z0-9_]+ *$/)) continue
            member = substr(member, RSTART)
            sub(/ +$/, "", member)
            printf "    printf(\"  %s %%zu %%zu\\n\", offsetof(%s, %s), sizeof(((%s *)0)->%s));\n", member, name, member, name, member
        }
    }
    print "    return 0;\n}"
}
