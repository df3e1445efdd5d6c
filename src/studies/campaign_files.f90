!> The files of a Monte Carlo campaign: the table of its statistics, and the estimates of every run,
!> which can be read back.
!>
!> What the runs are of stands in FILE.meta.json as lines of a namelist file: group &campaign, and a group &case for each
!> case, with its true offset and the errors that theory expects.
!>
!> While a campaign is at work its runs grow in a journal, `journal_path` of the file: the same as comment lines, and the
!> runs in the order in which they end. A last line without an end, of a program that was killed, does not count.
module gracecg_studies_campaign_files
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: AXES, MILLIMETRE
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_version, only: VERSION, file_comments
    use gracecg_base_text, only: string_t, integer_text, padded, parse_integer, real_text, join, split, logical_text
    use gracecg_files_file, only: text_file_t, read_text_file, text_file_of, output_file_t, appended_file_t, &
        remove_file
    use gracecg_files_data_table, only: data_table_t
    use gracecg_files_csv, only: csv_writer_t, SIDE_ENDING
    use gracecg_files_settings, only: settings_t, FULL_RANGE
    use gracecg_files_table, only: table_file_t, csv_of_text
    use gracecg_files_value, only: logical_from_text
    use gracecg_studies_campaign, only: campaign_t, new_campaign
    use gracecg_studies_monte_carlo, only: monte_carlo_t, some_runs, run_recorder_t
    use gracecg_studies_published, only: built_in_calibration
    implicit none
    private
    public :: campaign_table, write_table, write_runs, read_runs, journal_t, journal_path

    character(10), parameter :: COLUMNS(8) = [character(10) :: &
        'case', 'algorithm', 'run', 'dx_mm', 'dy_mm', 'dz_mm', 'converged', 'normalised']
    !! The last one as in monte_carlo_t; -1: not known
    real(dp), parameter :: LARGEST_OFFSET = 1e9_dp
    !! Of a run, mm: beyond what an estimate that diverged leaves, and far from where its statistics would overflow
    character(1), parameter :: LF = new_line('a')

    !> The runs of a campaign while they are made, kept one by one.
    type, extends(run_recorder_t) :: journal_t
        private
        type(appended_file_t) :: file
        character(:), allocatable :: path
        character(:), allocatable :: entry      !! The leading columns: 'front-1,assest-fde'
    contains
        procedure :: begin          !! Begins it, with the runs that there are
        procedure :: begin_entry    !! Says of which case and algorithm the runs are that follow
        procedure :: record => record_run
        procedure :: remove         !! The campaign is complete and kept elsewhere
    end type journal_t

contains

    !> RMS, mean and standard deviation of the errors beside prediction and published values.
    function campaign_table(campaign) result(table)
        type(campaign_t), intent(in) :: campaign
        type(data_table_t) :: table

        integer :: a, i, axis

        call table%column('case', 'a', 'case')
        call table%column('algorithm', 'a', 'algorithm')
        call table%column('axis', 'a', 'axis')
        call table%column('runs', 'i8', 'runs')
        call table%column('rms_mm', 'f12.5', 'here')
        call table%columns_of('mean_error_mm,std_mm')
        call table%column('predicted_mm', 'f12.5', 'theory')
        call table%column('published_mm', 'f12.5', 'report')
        do i = 1, size(campaign%cases)
            do a = 1, size(campaign%algorithms)
                associate (entry => campaign%entries(a, i))
                    do axis = 1, 3
                        call table%add(campaign%cases(i)%name, campaign%algorithms(a), AXES(axis))
                        call table%add([real(size(entry%run), dp), entry%statistics%rms(axis), entry%statistics%mean(axis), &
                                        entry%statistics%deviation(axis), entry%predicted(axis)])
                        call table%add(entry%published(axis), entry%published(axis) > 0)
                    end do
                end associate
            end do
        end do
    end function campaign_table

    !> The same as a CSV file.
    subroutine write_table(path, campaign, command, error)
        character(*), intent(in) :: path            !! Of the file to write; an existing one is replaced
        type(campaign_t), intent(in) :: campaign
        character(*), intent(in) :: command         !! That made the campaign, for FILE.meta.json
        type(error_t), allocatable, intent(out) :: error

        type(data_table_t) :: table

        table = campaign_table(campaign)
        call table%write(path, file_comments(command, 'seed '//integer_text(campaign%seed)//', runs 1 to '// &
                                             integer_text(campaign%runs)//', shard '//integer_text(campaign%shard)//' of '// &
                                             integer_text(campaign%shards)), error)
    end subroutine write_table

    !> Writes the estimate of every run.
    subroutine write_runs(path, campaign, command, error)
        character(*), intent(in) :: path    !! Of the file to write; an existing one is replaced
        type(campaign_t), intent(in) :: campaign
        character(*), intent(in) :: command !! The command line, for FILE.meta.json
        type(error_t), allocatable, intent(out) :: error

        type(csv_writer_t) :: file
        type(string_t), allocatable :: about(:)
        integer :: a, i, k

        call settings_lines(campaign, command, about, error)
        if (.not. allocated(error)) call file%open(path, join(COLUMNS, ','), padded(about), error)
        if (allocated(error)) return
        do i = 1, size(campaign%cases)
            do a = 1, size(campaign%algorithms)
                do k = 1, size(campaign%entries(a, i)%run)
                    call file%fields(row_of(campaign, a, i, k))
                end do
            end do
        end do
        call file%commit(error)
    end subroutine write_runs

    !> The fields of a run that an entry has.
    function row_of(campaign, a, i, k) result(fields)
        type(campaign_t), intent(in) :: campaign
        integer, intent(in) :: a, i, k      !! Numbers of algorithm and case; place of the run
        type(string_t) :: fields(size(COLUMNS))

        fields(1)%text = trim(campaign%cases(i)%name)
        fields(2)%text = trim(campaign%algorithms(a))
        associate (entry => campaign%entries(a, i))
            fields(3:) = estimate_fields(entry%run(k), entry%offset(:, k), entry%converged(k), entry%normalised(k))
        end associate
    end function row_of

    function estimate_fields(run, offset, converged, normalised) result(fields)
        integer, intent(in) :: run
        real(dp), intent(in) :: offset(3)       !! mm
        logical, intent(in) :: converged
        real(dp), intent(in) :: normalised
        type(string_t) :: fields(size(COLUMNS) - 2)

        integer :: axis

        fields(1)%text = integer_text(run)
        do axis = 1, 3
            fields(1 + axis)%text = real_text(offset(axis))
        end do
        fields(5)%text = trim(logical_text(converged))
        fields(6)%text = real_text(merge(normalised, -1.0_dp, ieee_is_finite(normalised)))
    end function estimate_fields

    !> Where the runs are kept while the file with them is not complete.
    pure function journal_path(path) result(journal)
        character(*), intent(in) :: path        !! Of the runs file
        character(len_trim(path) + 5) :: journal

        journal = trim(path)//'.part'
    end function journal_path

    !> Begins a journal, in place of an older one of that name: complete, with all runs that the campaign has, or not
    !> at all. Fails when it cannot be written.
    subroutine begin(self, path, campaign, command, error)
        class(journal_t), intent(inout) :: self
        character(*), intent(in) :: path            !! Of the journal
        type(campaign_t), intent(in) :: campaign    !! With all predictions
        character(*), intent(in) :: command         !! That makes the campaign, for the comments
        type(error_t), allocatable, intent(out) :: error

        type(output_file_t) :: file
        type(string_t), allocatable :: about(:)
        integer :: a, i, k

        self%path = path
        call settings_lines(campaign, command, about, error)
        if (.not. allocated(error)) call file%open(path, error)
        if (allocated(error)) return
        do i = 1, size(about)
            call file%line('# '//about(i)%text)
        end do
        call file%line(join(COLUMNS, ','))
        do i = 1, size(campaign%cases)
            do a = 1, size(campaign%algorithms)
                do k = 1, size(campaign%entries(a, i)%run)
                    call file%line(join(padded(row_of(campaign, a, i, k)), ','))
                end do
            end do
        end do
        call file%commit(error)
        if (.not. allocated(error)) call self%file%open(path, error)
    end subroutine begin

    subroutine begin_entry(self, campaign, a, i)
        class(journal_t), intent(inout) :: self
        type(campaign_t), intent(in) :: campaign
        integer, intent(in) :: a, i             !! Numbers of algorithm and case

        self%entry = trim(campaign%cases(i)%name)//','//trim(campaign%algorithms(a))//','
    end subroutine begin_entry

    subroutine record_run(self, run, offset, converged, normalised, error)
        class(journal_t), intent(inout) :: self
        integer, intent(in) :: run
        real(dp), intent(in) :: offset(3)
        logical, intent(in) :: converged
        real(dp), intent(in) :: normalised
        type(error_t), allocatable, intent(out) :: error

        if (all(ieee_is_finite(offset))) then
            call self%file%line(self%entry//join(padded(estimate_fields(run, offset/MILLIMETRE, converged, normalised)), &
                                                 ','), error)
        else
            call fail(error, 'run '//integer_text(run)//': the estimate is not a finite number')
        end if
    end subroutine record_run

    subroutine remove(self)
        class(journal_t), intent(inout) :: self

        call self%file%close()
        call remove_file(self%path)
    end subroutine remove

    !> What is told of a campaign beside its runs: settings, and what merging needs, true offsets and predictions.
    subroutine settings_lines(campaign, command, lines, error)
        type(campaign_t), intent(in) :: campaign
        character(*), intent(in) :: command
        type(string_t), allocatable, intent(out) :: lines(:)
        type(error_t), allocatable, intent(out) :: error

        type(settings_t) :: settings
        type(campaign_t) :: described
        character(:), allocatable :: text

        call settings%comment('gracecg '//VERSION//' '//command)
        described = campaign
        call describe(settings, .false., described)
        call settings%to_text(text, error)
        lines = split(text, LF)
    end subroutine settings_lines

    !> The settings of a campaign, to be written or read.
    subroutine describe(settings, reading, campaign)
        type(settings_t), intent(inout) :: settings
        logical, intent(in) :: reading              !! Then the campaign gets its cases, without runs
        type(campaign_t), intent(inout) :: campaign

        character(64) :: version_text, seed
        character(200) :: algorithms
        real(dp), allocatable :: predicted(:)
        integer :: a, cases, i
        logical :: ok

        version_text = VERSION
        seed = integer_text(campaign%seed)
        algorithms = ''
        cases = 0
        if (.not. reading) algorithms = join(campaign%algorithms, ',')
        if (.not. reading) cases = size(campaign%cases)
        call settings%group('campaign', '')
        call settings%text_value('version', version_text, 'of gracecg', required=.true.)
        if (version_text /= VERSION) call settings%reject('version', 'this file is not of gracecg '//VERSION//': make it anew')
        call settings%text_value('seed', seed, 'of the random numbers', required=.true.)
        call parse_integer(trim(seed), campaign%seed, ok)
        if (.not. ok) call settings%reject('seed', 'an integer is expected')
        call settings%integer_value('runs', campaign%runs, 1, huge(1), 'of the whole')
        call settings%integer_value('shards', campaign%shards, 1, huge(1), 'of it')
        call settings%integer_value('shard', campaign%shard, 1, campaign%shards, 'number of this one')
        call settings%text_value('algorithms', algorithms, 'by commas', required=.true.)
        call settings%end_group()
        call settings%count('case', cases)
        if (reading) campaign = new_campaign(padded(split(trim(algorithms), ',')), max(1, cases), campaign%seed, campaign%runs, &
                                             campaign%shard, campaign%shards)
        do i = 1, size(campaign%cases)
            associate (case => campaign%cases(i), entries => campaign%entries(:, i))
                predicted = [(entries(a)%predicted, a=1, size(entries))]
                call settings%group('case', '', index=i)
                call settings%text_value('name', case%name, '', required=.true.)
                call settings%integer_value('checksum', case%checksum, 0, huge(1), 'of all its settings')
                call settings%real_values('true_offset_mm', case%offset, -FULL_RANGE, FULL_RANGE, 'x, y, z', required=.true.)
                call settings%real_values('predicted_mm', predicted, 0.0_dp, FULL_RANGE, 'x, y, z of each algorithm', &
                                          required=.true.)
                call settings%end_group()
                do a = 1, merge(size(entries), 0, reading)
                    entries(a)%predicted = predicted(3*a - 2:3*a)
                end do
                if (reading) call built_in_calibration(trim(case%name), case%checksum, case%published)
            end associate
        end do
    end subroutine describe

    !> Reads a runs file or a journal: a campaign, or a part of it, without its statistics.
    !>
    !> Fails, naming file and line, when what tells of the runs or a row is not as `write_runs` writes it, or the file
    !> comes from another version.
    subroutine read_runs(path, campaign, error)
        character(*), intent(in) :: path    !! Of the file
        type(campaign_t), intent(out) :: campaign
        type(error_t), allocatable, intent(out) :: error

        type(text_file_t) :: text
        type(table_file_t) :: file
        type(settings_t) :: settings
        character(:), allocatable :: about

        call read_text_file(path, text, error)
        if (allocated(error)) return
        text = text_file_of(text%text(:index(text%text, LF, back=.true.)), path)
        call csv_of_text(text, COLUMNS, file, error, rows_needed=.false.)
        if (allocated(error)) return
        about = path
        if (index(text%text, '#') /= 1) about = path//SIDE_ENDING
        if (size(file%comments) == 0) then
            call fail(error, about//': is missing, or says nothing: it tells what the runs are of, and belongs beside them')
            return
        end if
        call settings%open_text(join(padded(file%comments), LF), about, error)
        if (allocated(error)) return
        call describe(settings, .true., campaign)
        call settings%finish(error)
        if (.not. allocated(error)) call read_rows(file, campaign, error)
    end subroutine read_runs

    !> The estimates, in any order.
    subroutine read_rows(file, campaign, error)
        type(table_file_t), intent(in) :: file
        type(campaign_t), intent(inout) :: campaign
        type(error_t), allocatable, intent(out) :: error

        type(monte_carlo_t) :: rows, own
        integer :: entry_of(file%row_count())
        integer :: i, a, k
        logical :: found(campaign%runs, size(campaign%entries))

        found = .false.
        rows = some_runs([(0, i=1, file%row_count())])
        do i = 1, file%row_count()
            call read_row(file, i, campaign, entry_of(i), rows, error)
            if (allocated(error)) return
            if (found(rows%run(i), entry_of(i))) &
                call file%fail_at(i, 'this run of this case and algorithm stands above already', error)
            if (allocated(error)) return
            found(rows%run(i), entry_of(i)) = .true.
        end do
        do k = 1, size(campaign%cases)
            do a = 1, size(campaign%algorithms)
                own = rows
                call own%keep(pack([(i, i=1, size(entry_of))], entry_of == a + (k - 1)*size(campaign%algorithms)))
                call campaign%entries(a, k)%add(own)
            end do
        end do
    end subroutine read_rows

    subroutine read_row(file, row, campaign, entry, rows, error)
        type(table_file_t), intent(in) :: file
        integer, intent(in) :: row
        type(campaign_t), intent(in) :: campaign
        integer, intent(out) :: entry                   !! Number of case and algorithm
        type(monte_carlo_t), intent(inout) :: rows      !! Gets this one; mm
        type(error_t), allocatable, intent(inout) :: error

        type(string_t), allocatable :: fields(:)
        character(:), allocatable :: problem
        integer :: a, axis, k

        entry = 0
        call file%get_fields(row, size(COLUMNS), join(COLUMNS, ','), fields, error)
        if (allocated(error)) return
        k = findloc(campaign%cases%name == fields(1)%text, .true., 1)
        a = findloc(campaign%algorithms == fields(2)%text, .true., 1)
        if (k == 0 .or. a == 0) then
            call file%fail_at(row, 'nothing tells of this case and algorithm above the rows or in FILE.meta.json', error)
            return
        end if
        entry = a + (k - 1)*size(campaign%algorithms)
        call file%get_integer(row, fields(3), 'column run', rows%run(row), error, 1, campaign%runs)
        do axis = 1, 3
            call file%get_real(row, fields(3 + axis), 'column '//trim(COLUMNS(3 + axis)), rows%offset(axis, row), error, &
                               -LARGEST_OFFSET, LARGEST_OFFSET, 'mm')
        end do
        call file%get_real(row, fields(8), 'column normalised', rows%normalised(row), error, low=-1.0_dp)
        call logical_from_text(fields(7)%text, rows%converged(row), problem)
        if (allocated(problem) .and. .not. allocated(error)) call file%fail_at(row, 'column converged: '//problem, error)
    end subroutine read_row
end module gracecg_studies_campaign_files
