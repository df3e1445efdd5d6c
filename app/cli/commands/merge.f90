!> gracecg merge: puts the shards of a Monte Carlo campaign together.
module gracecg_cli_merge
    use gracecg_base_error, only: error_t
    use gracecg_base_text, only: string_t, integer_text, padded
    use gracecg_studies_campaign, only: campaign_t
    use gracecg_studies_campaign_files, only: read_runs, write_table, write_runs
    use gracecg_studies_campaign_merge, only: merge_campaigns
    use gracecg_cli_campaign_tables, only: show_campaign, publish_campaign, read_campaign_files
    use gracecg_cli_arguments, only: arguments_t
    use gracecg_cli_console, only: console_t
    use gracecg_cli_results, only: add_format_option, take_format
    implicit none
    private
    public :: declare_merge, run_merge

    character(*), parameter :: COMMAND = 'merge'
    integer, parameter :: MOST_FILES = 100000
    integer, parameter :: MOST_SHOWN = 20       !! Shards that a message names

contains

    !> Arguments and help of `gracecg merge`.
    subroutine declare_merge(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe(COMMAND, 'FILE ...', 1, MOST_FILES, &
                                'Puts the shards of a campaign together: files that gracecg montecarlo '// &
                                '--shard K/N --runs-out FILE wrote. Table and files are those of the whole '// &
                                'campaign, to the last digit. Runs that no file has are reported, '// &
                                'with the shards they are of; a run '// &
                                'that several files have counts once.', &
                                'gracecg montecarlo --cases front-3 --runs 20 --shard 1/2 --runs-out '// &
                                'shard1.csv'//new_line('a')// &
                                'gracecg montecarlo --cases front-3 --runs 20 --shard 2/2 --runs-out '// &
                                'shard2.csv'//new_line('a')// &
                                'gracecg merge shard1.csv shard2.csv --out table.csv')
        call arguments%add_option('--out', 'FILE', 'CSV file for the statistics')
        call arguments%add_option('--runs-out', 'FILE', 'CSV file for the estimate of every run')
        call add_format_option(arguments)
    end subroutine declare_merge

    !> The work of `gracecg merge`.
    subroutine run_merge(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(campaign_t), allocatable :: parts(:)
        type(campaign_t) :: whole
        type(string_t), allocatable :: names(:)
        character(:), allocatable :: table_file, runs_file
        integer :: i, missing

        call read_campaign_files(arguments, table_file, runs_file, misuse)
        call take_format(arguments, console, misuse)
        if (allocated(misuse)) return

        allocate (parts(arguments%positional_count()), names(arguments%positional_count()))
        do i = 1, size(parts)
            names(i)%text = arguments%positional(i)
            call read_runs(names(i)%text, parts(i), error)
            if (allocated(error)) return
        end do
        call merge_campaigns(parts, padded(names), whole, missing, error)
        if (allocated(error)) return
        call show_campaign(whole, console)
        if (missing > 0) call console%warn(integer_text(missing)//' of '// &
                                              integer_text(whole%runs*size(whole%entries))// &
                                              ' estimates are missing: '//trim(left_out(parts, whole)))
        call publish_campaign(whole, COMMAND, console, error)
        if (allocated(error)) return
        if (table_file /= '') call write_table(table_file, whole, COMMAND, error)
        if (allocated(error)) return
        if (runs_file /= '') call write_runs(runs_file, whole, COMMAND, error)
    end subroutine run_merge

    !> Which shards have runs that no file has, with blanks behind it. They can be named when all files are of a campaign
    !> in equally many shards.
    function left_out(parts, whole) result(text)
        type(campaign_t), intent(in) :: parts(:), whole
        character(MOST_SHOWN*24 + 120) :: text

        logical, allocatable :: given(:)
        integer :: e, k, n, shown

        text = 'shards are left out'
        n = parts(1)%shards
        if (n < 2 .or. any(parts%shards /= n)) return
        text = 'run again shard'
        shown = 0
        do k = 1, n
            do e = 1, size(whole%entries)
                allocate (given(whole%runs), source=.false.)
                associate (entry => whole%entries(1 + mod(e - 1, size(whole%entries, 1)), &
                                                  1 + (e - 1)/size(whole%entries, 1)))
                    given(entry%run) = .true.
                end associate
                if (.not. all(given(k::n))) exit
                deallocate (given)
            end do
            if (.not. allocated(given)) cycle
            deallocate (given)
            shown = shown + 1
            if (shown <= MOST_SHOWN) text = trim(text)//trim(merge(',', ' ', shown > 1))//' '//integer_text(k)//'/'//integer_text(n)
        end do
        if (shown > MOST_SHOWN) text = trim(text)//' and '//integer_text(shown - MOST_SHOWN)//' more'
    end function left_out
end module gracecg_cli_merge
