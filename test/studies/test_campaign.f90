!> Campaigns in shards: the files of the shards, and what merging makes of them.
module test_campaign
    use vocabulary
    use calibrations
    use gracecg_files_file, only: text_file_t, read_text_file, text_file_of, remove_file
    use gracecg_files_table, only: table_file_t, read_csv
    use gracecg_planning_calibration, only: find_calibration
    use gracecg_simulation_simulator, only: new_simulator
    use gracecg_studies_campaign, only: campaign_t, new_campaign, add_case, predict_entry, run_entry, shard_runs, &
        merge_campaigns
    use gracecg_studies_campaign_files, only: write_table, write_runs, read_runs, journal_t, journal_path
    implicit none
    private
    public :: collect_campaign

    character(*), parameter :: LF = new_line('a')
    character(10), parameter :: ALGORITHMS(2) = [character(10) :: 'assest-fde', 'ascrest']

    integer, parameter :: RUNS = 5

contains

    subroutine collect_campaign(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('every-run-in-one-shard', test_shards), &
                    new_unittest('merged-is-the-whole', test_merged), &
                    new_unittest('missing-and-repeated-runs', test_missing), &
                    new_unittest('what-does-not-fit-together', test_misfits), &
                    new_unittest('names-that-cannot-be-written', test_names), &
                    new_unittest('a-journal-gone-on-with', test_journal), &
                    new_unittest('broken-journals', test_broken_journal), &
                    new_unittest('broken-files', test_broken), &
                    new_unittest('what-stands-beside-a-file', test_side_file)]
    end subroutine collect_campaign

    subroutine test_shards(error)
        type(error_type), allocatable, intent(out) :: error
        type(campaign_t) :: shard
        integer :: count_of(20), k

        count_of = 0
        do k = 1, 7
            shard = new_campaign(ALGORITHMS, 1, 1_i8, 20, k, 7)
            count_of(shard_runs(shard)) = count_of(shard_runs(shard)) + 1
            call check(error, all(mod(shard_runs(shard) - 1, 7) == k - 1))
        end do
        call check(error, all(count_of == 1))
    end subroutine test_shards

    !> A campaign of a built-in case and of one of the user's, which has blanks in its name.
    logical function campaign_fails(error, name, shard, shards, threads, campaign, seed)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: name            !! Of its files, below FOLDER
        integer, intent(in) :: shard, shards, threads
        type(campaign_t), intent(out) :: campaign
        integer(i8), intent(in), optional :: seed
        type(calibration_t) :: calibration
        type(simulator_t) :: simulator
        type(error_t), allocatable :: failure
        integer :: i, a

        campaign = new_campaign(ALGORITHMS, 2, 4_i8, RUNS, shard, shards)
        if (present(seed)) campaign%seed = seed
        do i = 1, 2
            if (i == 1) call find_calibration('front-3', calibration, failure)
            if (i == 2) call find_calibration('back-1', calibration, failure)
            if (i == 2) calibration%case%name = 'my own case'
            if (.not. allocated(failure)) call add_case(campaign, i, calibration, failure)
            if (.not. allocated(failure)) call new_simulator(calibration%case, simulator, failure)
            do a = 1, size(ALGORITHMS)
                if (.not. allocated(failure)) &
                    call run_entry(campaign, a, i, simulator, calibration%options, threads, failure)
            end do
        end do
        if (.not. allocated(failure)) call write_runs(FOLDER//name//'_runs.csv', campaign, 'test', failure)
        if (.not. allocated(failure)) call write_table(FOLDER//name//'_table.csv', campaign, 'test', failure)
        campaign_fails = failed(error, failure)
    end function campaign_fails

    !> Reads the runs of some campaigns back and merges them.
    subroutine merge(names, whole, missing, failure)
        character(*), intent(in) :: names(:)
        type(campaign_t), intent(out) :: whole
        integer, intent(out) :: missing
        type(error_t), allocatable, intent(out) :: failure
        type(campaign_t), allocatable :: parts(:)
        integer :: i

        missing = -1
        allocate (parts(size(names)))
        do i = 1, size(names)
            call read_runs(FOLDER//trim(names(i))//'_runs.csv', parts(i), failure)
            if (allocated(failure)) return
        end do
        call merge_campaigns(parts, names, whole, missing, failure)
    end subroutine merge

    !> File for file, comment lines included, on whatever number of threads.
    subroutine test_merged(error)
        type(error_type), allocatable, intent(out) :: error
        type(campaign_t) :: campaign, whole
        type(error_t), allocatable :: failure
        integer :: missing

        if (campaign_fails(error, 'whole', 1, 1, 1, campaign)) return
        if (campaign_fails(error, 'shard1', 1, 3, 2, campaign)) return
        if (campaign_fails(error, 'shard2', 2, 3, 1, campaign)) return
        if (campaign_fails(error, 'shard3', 3, 3, 2, campaign)) return
        call merge([character(6) :: 'shard3', 'shard1', 'shard2'], whole, missing, failure)
        if (.not. allocated(failure)) call write_runs(FOLDER//'merged_runs.csv', whole, 'test', failure)
        if (.not. allocated(failure)) call write_table(FOLDER//'merged_table.csv', whole, 'test', failure)
        call check_passes(error, failure)
        call check(error, missing, 0)
        call check_same_files(error, 'whole_runs.csv', 'merged_runs.csv')
        call check_same_files(error, 'whole_table.csv', 'merged_table.csv')
    end subroutine test_merged

    subroutine test_missing(error)
        type(error_type), allocatable, intent(out) :: error
        type(campaign_t) :: campaign, whole
        type(error_t), allocatable :: failure
        integer :: missing

        if (campaign_fails(error, 'shard1', 1, 3, 2, campaign)) return
        if (campaign_fails(error, 'shard2', 2, 3, 2, campaign)) return
        call merge([character(6) :: 'shard1', 'shard2', 'shard1'], whole, missing, failure)
        call check_passes(error, failure)
        call check(error, missing, 4)      ! run 3 of four entries
        call check(error, all(whole%entries(1, 2)%run == [1, 2, 4, 5]))
    end subroutine test_missing

    subroutine test_misfits(error)
        type(error_type), allocatable, intent(out) :: error
        type(campaign_t) :: campaign, whole, changed
        type(error_t), allocatable :: failure
        integer :: missing

        if (campaign_fails(error, 'shard1', 1, 3, 2, campaign)) return
        if (campaign_fails(error, 'seed7', 2, 3, 2, changed, seed=7_i8)) return
        call merge([character(6) :: 'shard1', 'seed7'], whole, missing, failure)
        call check_fails(error, failure, 'shard1 ... seed7 ... different seeds: 4 and 7')

        changed = campaign
        changed%runs = 6
        call refused('campaigns of 5 and 6 runs')
        changed = campaign
        changed%cases(2)%name = 'another'
        call refused('different cases or algorithms')
        changed = campaign
        changed%cases(2)%checksum = changed%cases(2)%checksum + 1
        call refused('different settings of the case my own case')
        changed = campaign
        changed%entries(2, 1)%offset(3, 2) = changed%entries(2, 1)%offset(3, 2) + 1e-4
        call refused('contradict each other: front-3, ascrest, run 4')
        changed = campaign
        changed%entries(1, 2)%converged(1) = .false.
        call refused('contradict each other: my own case, assest-fde, run 1')

    contains

        !> The changed campaign must not go with the first one.
        subroutine refused(parts)
            character(*), intent(in) :: parts

            call merge_campaigns([campaign, changed], ['a', 'b'], whole, missing, failure)
            call check_fails(error, failure, 'a and b ... '//parts)
        end subroutine refused
    end subroutine test_misfits

    subroutine test_names(error)
        type(error_type), allocatable, intent(out) :: error
        type(campaign_t) :: campaign
        type(calibration_t) :: calibration
        type(error_t), allocatable :: failure

        campaign = new_campaign(ALGORITHMS, 2, 1_i8, 5, 1, 1)
        call take_calibration('front-1', calibration)
        call add_case(campaign, 1, calibration, failure)
        if (failed(error, failure)) return
        call add_case(campaign, 2, calibration, failure)
        call check_fails(error, failure, 'two cases have the name "front-1"')
        calibration%case%name = 'a, b'
        call add_case(campaign, 2, calibration, failure)
        call check_fails(error, failure, 'no comma ... a, b')
    end subroutine test_names

    !> One entry with runs 1, 4 and 5 of 5 in a journal.
    subroutine make_journal(campaign, simulator, options, journal)
        type(campaign_t), intent(out) :: campaign
        type(simulator_t), intent(out) :: simulator
        type(estimation_options_t), intent(out) :: options
        type(text_file_t), intent(out) :: journal
        type(calibration_t) :: calibration
        type(journal_t) :: file
        type(campaign_t) :: some
        type(error_t), allocatable :: failure

        call take_calibration('front-3', calibration)
        options = calibration%options
        campaign = new_campaign(['optimal'], 1, 4_i8, RUNS, 1, 1)
        call add_case(campaign, 1, calibration, failure)
        if (.not. allocated(failure)) call new_simulator(calibration%case, simulator, failure)
        if (.not. allocated(failure)) call predict_entry(campaign, 1, 1, simulator, options, failure)
        ! runs 4 and 5 first, then 1: the order is that in which they end
        some = campaign
        some%shard = 4
        some%shards = 5
        if (.not. allocated(failure)) call file%begin(FOLDER//'j.csv.part', campaign, 'test', failure)
        call file%begin_entry(campaign, 1, 1)
        if (.not. allocated(failure)) call run_entry(some, 1, 1, simulator, options, 1, failure, recorder=file)
        some%shard = 5
        if (.not. allocated(failure)) call run_entry(some, 1, 1, simulator, options, 1, failure, recorder=file)
        some%shard = 1
        if (.not. allocated(failure)) call run_entry(some, 1, 1, simulator, options, 1, failure, recorder=file)
        if (.not. allocated(failure)) call read_text_file(FOLDER//'j.csv.part', journal, failure)
        call need(failure)
    end subroutine make_journal

    !> A journal has every run at once; gone on with, the campaign is that of one never stopped, to the last bit,
    !> whatever is missing of its last line.
    subroutine test_journal(error)
        type(error_type), allocatable, intent(out) :: error
        type(campaign_t) :: campaign, whole, kept
        type(simulator_t) :: simulator
        type(estimation_options_t) :: options
        type(text_file_t) :: journal
        type(error_t), allocatable :: failure
        integer :: last, cut

        call check(error, journal_path('a/b.csv '), 'a/b.csv.part')
        call make_journal(campaign, simulator, options, journal)
        whole = campaign
        call run_entry(whole, 1, 1, simulator, options, 2, failure)
        if (.not. allocated(failure)) call write_runs(FOLDER//'whole.csv', whole, 'test', failure)
        last = journal%first(journal%line_count())
        do cut = last - 1, len(journal%text), 7
            call make_file('torn.csv.part', journal%text(:cut))
            kept = campaign
            call read_runs(FOLDER//'torn.csv.part', kept, failure)
            if (failed(error, failure)) return
            if (cut < len(journal%text)) call check(error, all(kept%entries(1, 1)%run == [4, 5]))
            if (cut == len(journal%text)) call check(error, all(kept%entries(1, 1)%run == [1, 4, 5]))
            call run_entry(kept, 1, 1, simulator, options, 2, failure)
            if (.not. allocated(failure)) call write_runs(FOLDER//'kept.csv', kept, 'test', failure)
            call check_passes(error, failure)
            call check_same_files(error, 'whole.csv', 'kept.csv')
            call check(error, abs(kept%entries(1, 1)%mean_normalised - whole%entries(1, 1)%mean_normalised) <= 0)
        end do
    end subroutine test_journal

    subroutine test_broken_journal(error)
        type(error_type), allocatable, intent(out) :: error
        type(campaign_t) :: campaign, read_back
        type(simulator_t) :: simulator
        type(estimation_options_t) :: options
        type(text_file_t) :: journal
        type(error_t), allocatable :: failure

        call make_journal(campaign, simulator, options, journal)
        call refused(journal%line(journal%line_count())//LF, 'stands above already')
        call refused('front-3,optimal,2,1,2,3,true'//LF, '7 columns, expected 8')
        call refused('front-3,optimal,2,1,2,3,true,x'//LF, 'column normalised')
        call refused('front-3,optimal,6,1,2,3,true,0'//LF, 'from 1 to 5')

    contains

        !> The journal with one line more.
        subroutine refused(line, parts)
            character(*), intent(in) :: line, parts

            call make_file('broken.csv.part', journal%text//line)
            call read_runs(FOLDER//'broken.csv.part', read_back, failure)
            call check_fails(error, failure, parts)
        end subroutine refused
    end subroutine test_broken_journal

    !> A file of runs with one line changed, what stands beside it as comments above the rows.
    subroutine test_broken(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: ROW = 'front-3,assest-fde,1,'
        type(campaign_t) :: campaign
        type(text_file_t) :: sound
        type(error_t), allocatable :: failure

        if (campaign_fails(error, 'sound', 1, 2, 2, campaign)) return
        call read_with_comments(error, 'sound_runs.csv', sound)
        if (allocated(error)) return
        call broken('#     version', '# version = ''0.0.0''', 'broken.csv:3 ... make it anew')
        call broken('#     seed', '', 'key "seed" ... is missing')
        call broken('#     seed', '# seed = ''x''', 'broken.csv:4 ... an integer is expected')
        call broken('#     runs', '# runs = 0', 'broken.csv:5 ... an integer from 1')
        call broken('#     shard ', '# shard = 3', 'broken.csv:7 ... an integer from 1 to 2')
        call broken('#     true_offset_mm', '# true_offset_mm = 1, 2, x', 'broken.csv:13 ... "x"')
        call broken('#     predicted_mm', '# predicted_mm = 1, 2, 3', 'broken.csv:14 ... 6 numbers')
        call broken('#     name', '# nam = 1', 'broken.csv:10 ... key "name" ... is "nam" there')
        call broken('case,algorithm', 'case,algorithm,run', '3 columns, expected 8 ... the columns must be case,')
        call broken(ROW, ROW//'1,2,3', '6 columns, expected 8')
        call broken(ROW, 'front-2,assest-fde,1,1,2,3,true,0', 'nothing tells of this case')
        call broken(ROW, 'front-3,assest-fde,6,1,2,3,true,0', 'from 1 to 5')
        call broken(ROW, 'front-3,assest-fde,1.5,1,2,3,true,0', 'column run')
        call broken(ROW, ROW//'1,nan,3,true,0', 'finite number ... dy_mm')
        call broken(ROW, ROW//'1,1e30,3,true,0', 'from -1000000000 to 1000000000 mm')
        call broken(ROW, ROW//'1,2,3,yes,0', 'column converged')
        call broken(ROW, 'front-3,assest-fde,3,1,2,3,true,0', 'stands above already')

    contains

        !> Replaces the first line that begins so (by nothing: takes it out). Reading must fail.
        subroutine broken(beginning, replacement, parts)
            character(*), intent(in) :: beginning, replacement, parts
            character(:), allocatable :: text
            integer :: i
            logical :: done

            text = ''
            done = .false.
            do i = 1, sound%line_count()
                if (.not. done .and. index(sound%line(i), beginning) == 1) then
                    if (replacement /= '') text = text//replacement//LF
                    done = .true.
                else
                    text = text//sound%line(i)//LF
                end if
            end do
            call check(error, done, beginning)
            call make_file('broken.csv', text)
            call read_runs(FOLDER//'broken.csv', campaign, failure)
            call check_fails(error, failure, parts)
        end subroutine broken
    end subroutine test_broken

    !> A file of runs with the comments above, as a journal has them.
    subroutine read_with_comments(error, name, text_file)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: name
        type(text_file_t), intent(out) :: text_file
        type(table_file_t) :: file
        type(error_t), allocatable :: failure
        character(:), allocatable :: text
        integer :: i

        call read_csv(FOLDER//name, [character(10) :: 'case', 'algorithm', 'run', 'dx_mm', 'dy_mm', 'dz_mm', &
                                     'converged', 'normalised'], file, failure)
        if (failed(error, failure)) return
        call check(error, size(file%comments) > 2 .and. index(file%text%text, '#') == 0, 'comments beside the file')
        text = ''
        do i = 1, size(file%comments)
            text = text//'# '//file%comments(i)%text//LF
        end do
        text_file = text_file_of(text//file%text%text, name)
    end subroutine read_with_comments

    !> A file without what stands beside it is refused.
    subroutine test_side_file(error)
        type(error_type), allocatable, intent(out) :: error
        type(campaign_t) :: campaign, read_back
        type(text_file_t) :: side
        type(error_t), allocatable :: failure
        integer :: i

        if (campaign_fails(error, 'beside', 1, 2, 2, campaign)) return
        call read_text_file(FOLDER//'beside_runs.csv.meta.json', side, failure)
        call remove_file(FOLDER//'beside_runs.csv.meta.json')
        call read_runs(FOLDER//'beside_runs.csv', read_back, failure)
        call check_fails(error, failure, 'beside_runs.csv.meta.json ... is missing')
        i = index(side%text, 'seed = ''4''')
        call make_file('beside_runs.csv.meta.json', side%text(:i - 1)//'seed = ''x'''//side%text(i + 10:))
        call read_runs(FOLDER//'beside_runs.csv', read_back, failure)
        call check_fails(error, failure, 'beside_runs.csv.meta.json:4 ... key "seed"')
    end subroutine test_side_file
end module test_campaign
