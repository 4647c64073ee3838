# SPDX-License-Identifier: Apache-2.0
# fish completion of ovoid, from what the program tells of itself (see ovoid.bash).

function __ovoid_flags
    set -l words (commandline -opc)
    ovoid $words[2] --list-flags 2>/dev/null | while read -d \t names form text
        for name in (string split , -- $names)
            printf '%s\t%s\n' $name $text
        end
    end
end

function __ovoid_choices
    set -l words (commandline -opc)
    ovoid $words[2] --list-flags 2>/dev/null | while read -d \t names form text
        if contains -- $words[-1] (string split , -- $names); and string match -qr '^[^A-Z]*\|[^A-Z]*$' -- $form
            string split '|' -- $form
        end
    end
end

complete -c ovoid -n __fish_use_subcommand -f -a '(ovoid --list-flags | cut -f1,3)'
complete -c ovoid -n 'not __fish_use_subcommand; and string match -q -- "-*" (commandline -ct)' -f -a '(__ovoid_flags)'
complete -c ovoid -n 'not __fish_use_subcommand; and test -n "(__ovoid_choices)"' -a '(__ovoid_choices)'
