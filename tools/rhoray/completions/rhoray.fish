# Completion of rhoray for fish: `rhoray complete` knows what may follow.
function __rhoray_complete
    set -l words (commandline -opc) (commandline -ct)
    set -l last $words[-1]
    # fish completes whole words: values behind --option= are offered with it.
    set -l before ''
    if string match -q -- '--*=*' $last
        set before (string replace -r -- '=.*' '=' $last)
    end
    for line in ($words[1] complete $words[2..-1] 2>/dev/null)
        switch $line
            case :files
                __fish_complete_path (string replace -r -- '^--[^=]*=' '' $last) | string replace -r -- '^' $before
            case :folders
                __fish_complete_directories (string replace -r -- '^--[^=]*=' '' $last) | string replace -r -- '^' $before
            case '*'
                echo $before$line
        end
    end
end
complete -c rhoray -f -a '(__rhoray_complete)'
