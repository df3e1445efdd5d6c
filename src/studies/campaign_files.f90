!> The files of a Monte Carlo campaign: the table of its statistics, and the estimates of every run,
!> which can be read back.
!>
!> What FILE.meta.json tells of a runs file, in this order:
!>
!>     gracecg VERSION COMMAND
!>     seed S, runs 1 to N
!>     shard K of M                                     (where it is not the whole)
!>     case NAME checksum C offset_mm X Y Z             (each case)
!>     predicted NAME ALGORITHM X Y Z                   (each algorithm of the case, mm)
!>
!> While a campaign is at work its runs grow in a journal, `journal_path` of the file: the same as comment lines, the
!> runs in the order in which they end, and one column more, their errors squared in units of their own covariances. A
!> last line without an end, of a program that was killed, does not count.
module gracecg_studies_campaign_files
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: AXES, MILLIMETRE
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_version, only: VERSION
    use gracecg_base_text, only: string_t, append, integer_text, padded, parse_integer, parse_real, &
        real_text, join, split_words, logical_text, parse_logical
    use gracecg_files_file, only: text_file_t, read_text_file, text_file_of, output_file_t, appended_file_t, &
        remove_file
    use gracecg_files_data_table, only: data_table_t
    use gracecg_files_csv, only: csv_writer_t
    use gracecg_files_table, only: table_file_t, csv_of_text
    use gracecg_studies_campaign, only: campaign_t, campaign_case_t
    use gracecg_studies_monte_carlo, only: monte_carlo_t, some_runs, run_recorder_t
    use gracecg_studies_published_case, only: built_in_calibration
    implicit none
    private
    public :: campaign_table, write_table, write_runs, read_runs, journal_t, journal_path

    character(10), parameter :: JOURNAL_COLUMNS(8) = [character(10) :: &
        'case', 'algorithm', 'run', 'dx_mm', 'dy_mm', 'dz_mm', 'converged', 'normalised']
    !! The last one of a journal alone: as in monte_carlo_t; -1: not known
    integer, parameter :: RUNS_COLUMNS = 7      !! That a runs file has of them
    character(*), parameter :: SHARD_COMMENT = 'shard ', CASE_COMMENT = 'case ', PREDICTED_COMMENT = 'predicted '
    !! How they begin
    integer, parameter :: COMMENT_LENGTH = 200
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

    function settings_comments(campaign, command) result(comments)
        type(campaign_t), intent(in) :: campaign
        character(*), intent(in) :: command
        character(COMMENT_LENGTH), allocatable :: comments(:)

        comments = [character(COMMENT_LENGTH) :: 'gracecg '//VERSION//' '//command, 'seed '// &
                    integer_text(campaign%seed)//', runs 1 to '//integer_text(campaign%runs)]
        if (campaign%shards > 1) then
            comments = [character(COMMENT_LENGTH) :: comments, 'shard '//integer_text(campaign%shard)// &
                        ' of '//integer_text(campaign%shards)]
        end if
    end function settings_comments

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
                        call table%add(campaign%cases(i)%name)
                        call table%add(campaign%algorithms(a))
                        call table%add(AXES(axis))
                        call table%add(size(entry%run))
                        call table%add([entry%statistics%rms(axis), entry%statistics%mean(axis), &
                                        entry%statistics%deviation(axis), entry%predicted(axis)])
                        if (entry%published(axis) > 0) then
                            call table%add(entry%published(axis))
                        else
                            call table%add_nothing()
                        end if
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
        call table%write(path, settings_comments(campaign, command), error)
    end subroutine write_table

    !> Writes the estimate of every run.
    subroutine write_runs(path, campaign, command, error)
        character(*), intent(in) :: path    !! Of the file to write; an existing one is replaced
        type(campaign_t), intent(in) :: campaign
        character(*), intent(in) :: command !! The command line, for FILE.meta.json
        type(error_t), allocatable, intent(out) :: error

        type(csv_writer_t) :: file
        type(string_t) :: fields(size(JOURNAL_COLUMNS))
        integer :: a, i, k

        call file%open(path, join(JOURNAL_COLUMNS(:RUNS_COLUMNS), ','), all_comments(campaign, command), error)
        if (allocated(error)) return
        do i = 1, size(campaign%cases)
            do a = 1, size(campaign%algorithms)
                do k = 1, size(campaign%entries(a, i)%run)
                    fields = row_of(campaign, a, i, k)
                    call file%fields(fields(:RUNS_COLUMNS))
                end do
            end do
        end do
        call file%commit(error)
    end subroutine write_runs

    !> The fields of a run that an entry has.
    function row_of(campaign, a, i, k) result(fields)
        type(campaign_t), intent(in) :: campaign
        integer, intent(in) :: a, i, k      !! Numbers of algorithm and case; place of the run
        type(string_t) :: fields(size(JOURNAL_COLUMNS))

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
        type(string_t) :: fields(size(JOURNAL_COLUMNS) - 2)

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
        character(COMMENT_LENGTH), allocatable :: comments(:)
        integer :: a, i, k

        self%path = path
        call file%open(path, error)
        if (allocated(error)) return
        comments = all_comments(campaign, command)
        do i = 1, size(comments)
            call file%line('# '//trim(comments(i)))
        end do
        call file%line(join(JOURNAL_COLUMNS, ','))
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

    !> What is told of a campaign: settings, and what merging needs beside the estimates, true offsets and predictions.
    function all_comments(campaign, command) result(comments)
        type(campaign_t), intent(in) :: campaign
        character(*), intent(in) :: command
        character(COMMENT_LENGTH), allocatable :: comments(:)

        integer :: a, i

        comments = settings_comments(campaign, command)
        do i = 1, size(campaign%cases)
            associate (case => campaign%cases(i))
                comments = [comments, comment(CASE_COMMENT//trim(case%name)//' checksum '//integer_text(case%checksum)// &
                                              ' offset_mm', case%offset)]
                comments = [comments, (comment(PREDICTED_COMMENT//trim(case%name)//' '//trim(campaign%algorithms(a)), &
                                               campaign%entries(a, i)%predicted), a=1, size(campaign%algorithms))]
            end associate
        end do
    end function all_comments

    function comment(text, values) result(line)
        character(*), intent(in) :: text
        real(dp), intent(in) :: values(3)
        character(COMMENT_LENGTH) :: line

        line = text//' '//real_text(values(1))//' '//real_text(values(2))//' '//real_text(values(3))
    end function comment

    !> Reads a runs file or a journal: a campaign, or a part of it, without its statistics.
    !>
    !> Fails, naming file and line, when a comment or a row is not as `write_runs` writes it, or the file
    !> comes from a version that is not known to write such files.
    subroutine read_runs(path, campaign, error)
        character(*), intent(in) :: path    !! Of the file
        type(campaign_t), intent(out) :: campaign
        type(error_t), allocatable, intent(out) :: error

        type(text_file_t) :: text
        type(table_file_t) :: file
        integer :: columns

        call read_text_file(path, text, error)
        if (allocated(error)) return
        columns = RUNS_COLUMNS
        if (index(text%text, LF//join(JOURNAL_COLUMNS, ',')//LF) > 0) then
            columns = size(JOURNAL_COLUMNS)
            text = text_file_of(text%text(:index(text%text, LF, back=.true.)), path)
        end if
        call csv_of_text(text, JOURNAL_COLUMNS(:columns), file, error, rows_needed=.false.)
        if (.not. allocated(error)) call read_settings(file, campaign, error)
        if (.not. allocated(error)) call read_cases(file, campaign, error)
        if (.not. allocated(error)) call read_rows(file, columns, campaign, error)
    end subroutine read_runs

    !> The first two comments.
    subroutine read_settings(file, campaign, error)
        type(table_file_t), intent(in) :: file
        type(campaign_t), intent(inout) :: campaign
        type(error_t), allocatable, intent(out) :: error

        type(string_t), allocatable :: words(:)
        logical :: ok(2)

        if (size(file%comments) < 2) then
            call file%fail_at_comment(0, 'what tells of version, seed and cases is missing: it stands in this '// &
                                      'file, which belongs beside the one with the runs', error)
            return
        end if
        if (index(file%comments(1)%text, 'gracecg '//VERSION//' ') /= 1) then
            call file%fail_at_comment(1, 'this file is not of gracecg '//VERSION//': make it anew', error)
            return
        end if
        words = split_words(file%comments(2)%text)
        ok = .false.
        if (size(words) == 6) then
            if (words(1)%text == 'seed' .and. words(3)%text//' '//words(4)%text//' '//words(5)%text == &
                'runs 1 to') then
                call parse_integer(words(2)%text(:len(words(2)%text) - 1), campaign%seed, ok(1))
                call parse_integer(words(6)%text, campaign%runs, ok(2))
            end if
        end if
        if (.not. all(ok) .or. campaign%runs < 1) &
            call file%fail_at_comment(2, 'expected "seed S, runs 1 to N"', error)
    end subroutine read_settings

    !> The comments with cases and predictions.
    subroutine read_cases(file, campaign, error)
        type(table_file_t), intent(in) :: file
        type(campaign_t), intent(inout) :: campaign
        type(error_t), allocatable, intent(out) :: error

        type(string_t), allocatable :: algorithms(:)
        type(campaign_case_t), allocatable :: cases(:)
        character(16) :: algorithm
        real(dp) :: values(3)
        real(dp), allocatable :: predicted(:, :)        ! (3, predictions)
        integer :: i, a
        logical :: ok

        allocate (algorithms(0), cases(0), predicted(3, 0))
        do i = 3, size(file%comments)
            associate (line => file%comments(i)%text)
                ok = .false.
                if (index(line, SHARD_COMMENT) == 1) then
                    call read_shard_comment(line, campaign, ok)
                else if (index(line, CASE_COMMENT) == 1) then
                    cases = [cases, campaign_case_t()]
                    call read_case_comment(line, cases(size(cases)), ok)
                else if (index(line, PREDICTED_COMMENT) == 1 .and. size(cases) > 0) then
                    call read_predicted_comment(line, trim(cases(size(cases))%name), algorithm, values, ok)
                    if (size(cases) == 1 .and. ok) call append(algorithms, trim(algorithm))
                    a = size(predicted, 2) + 1 - (size(cases) - 1)*size(algorithms)
                    if (ok) predicted = reshape([predicted, values], [3, size(predicted, 2) + 1])
                    if (ok .and. size(cases) > 1) ok = a >= 1 .and. a <= size(algorithms)
                    if (ok) ok = algorithm == algorithms(a)%text
                end if
            end associate
            if (.not. ok) then
                call file%fail_at_comment(i, 'expected "case NAME checksum C offset_mm X Y Z", or "predicted NAME '// &
                                          'ALGORITHM X Y Z" for each algorithm of the case above', error)
                return
            end if
        end do
        if (size(cases) == 0 .or. size(predicted, 2) /= size(cases)*size(algorithms)) then
            call file%fail_at_comment(0, 'the comments must have each case and a prediction of each '// &
                                      'algorithm', error)
            return
        end if
        campaign%cases = cases
        allocate (campaign%algorithms(size(algorithms)), campaign%entries(size(algorithms), size(cases)))
        campaign%algorithms = padded(algorithms)
        do i = 1, size(predicted, 2)
            campaign%entries(1 + mod(i - 1, size(algorithms)), 1 + (i - 1)/size(algorithms))%predicted = predicted(:, i)
        end do
    end subroutine read_cases

    !> "shard K of M"
    subroutine read_shard_comment(line, campaign, ok)
        character(*), intent(in) :: line
        type(campaign_t), intent(inout) :: campaign
        logical, intent(out) :: ok

        type(string_t), allocatable :: words(:)
        logical :: fine(2)

        words = split_words(line)
        ok = size(words) == 4
        if (.not. ok) return
        call parse_integer(words(2)%text, campaign%shard, fine(1))
        call parse_integer(words(4)%text, campaign%shards, fine(2))
        ok = all(fine) .and. campaign%shard >= 1 .and. campaign%shard <= campaign%shards
    end subroutine read_shard_comment

    !> "case NAME checksum C offset_mm X Y Z"; a name may have blanks.
    subroutine read_case_comment(line, case, ok)
        character(*), intent(in) :: line
        type(campaign_case_t), intent(out) :: case
        logical, intent(out) :: ok

        type(string_t), allocatable :: words(:)
        integer :: n

        words = split_words(line)
        n = size(words)
        ok = n >= 8
        if (ok) ok = words(n - 3)%text == 'offset_mm' .and. words(n - 5)%text == 'checksum'
        if (ok) call read_three(words(n - 2:), case%offset, ok)
        if (ok) call parse_integer(words(n - 4)%text, case%checksum, ok)
        if (.not. ok) return
        case%name = line(len(CASE_COMMENT) + 1:index(line, ' checksum ', back=.true.) - 1)
        call built_in_calibration(trim(case%name), case%checksum, case%published)
    end subroutine read_case_comment

    !> "predicted NAME ALGORITHM X Y Z" of a case
    subroutine read_predicted_comment(line, name, algorithm, values, ok)
        character(*), intent(in) :: line, name
        character(*), intent(out) :: algorithm
        real(dp), intent(out) :: values(3)
        logical, intent(out) :: ok

        type(string_t), allocatable :: words(:)

        algorithm = ''
        values = 0
        ok = index(line, PREDICTED_COMMENT//name//' ') == 1
        if (.not. ok) return
        words = split_words(line(len(PREDICTED_COMMENT) + len(name) + 2:))
        ok = size(words) == 4
        if (.not. ok) return
        algorithm = words(1)%text
        call read_three(words(2:), values, ok)
    end subroutine read_predicted_comment

    subroutine read_three(words, values, ok)
        type(string_t), intent(in) :: words(:)
        real(dp), intent(out) :: values(3)
        logical, intent(out) :: ok

        logical :: fine(3)
        integer :: i

        do i = 1, 3
            call parse_real(words(i)%text, values(i), fine(i))
        end do
        ok = all(fine)
    end subroutine read_three

    !> The estimates. Rows of an entry stand together, in increasing order of the runs; those of a journal in any.
    subroutine read_rows(file, columns, campaign, error)
        type(table_file_t), intent(in) :: file
        integer, intent(in) :: columns              !! Of the file: RUNS_COLUMNS, or those of a journal
        type(campaign_t), intent(inout) :: campaign
        type(error_t), allocatable, intent(out) :: error

        type(monte_carlo_t) :: rows, own
        integer, allocatable :: entry_of(:)
        integer :: i, a, k, e
        logical :: found(campaign%runs, size(campaign%entries))

        found = .false.
        rows = some_runs([(0, i=1, file%row_count())])
        allocate (entry_of(file%row_count()))
        do i = 1, file%row_count()
            call read_row(file, i, columns, campaign, entry_of(i), rows, error)
            if (allocated(error)) return
            if (found(rows%run(i), entry_of(i))) &
                call file%fail_at(i, 'this run of this case and algorithm stands above already', error)
            if (i > 1 .and. columns == RUNS_COLUMNS) then
                if (entry_of(i) < entry_of(i - 1) .or. (entry_of(i) == entry_of(i - 1) .and. &
                                                        rows%run(i) <= rows%run(i - 1))) &
                    call file%fail_at(i, 'the rows are not in the order of case, algorithm and run', error)
            end if
            if (allocated(error)) return
            found(rows%run(i), entry_of(i)) = .true.
        end do
        do k = 1, size(campaign%cases)
            do a = 1, size(campaign%algorithms)
                e = a + (k - 1)*size(campaign%algorithms)
                own = rows
                call own%keep(pack([(i, i=1, size(entry_of))], entry_of == e))
                campaign%entries(a, k)%monte_carlo_t = some_runs([integer ::])
                call campaign%entries(a, k)%add(own)
            end do
        end do
    end subroutine read_rows

    subroutine read_row(file, row, columns, campaign, entry, rows, error)
        type(table_file_t), intent(in) :: file
        integer, intent(in) :: row, columns
        type(campaign_t), intent(in) :: campaign
        integer, intent(out) :: entry                   !! Number of case and algorithm
        type(monte_carlo_t), intent(inout) :: rows      !! Gets this one; mm
        type(error_t), allocatable, intent(out) :: error

        type(string_t), allocatable :: fields(:)
        integer :: a, k
        logical :: ok

        entry = 0
        call file%get_fields(row, columns, join(JOURNAL_COLUMNS(:columns), ','), fields, error)
        if (allocated(error)) return
        k = findloc(campaign%cases%name == fields(1)%text, .true., 1)
        a = findloc(campaign%algorithms == fields(2)%text, .true., 1)
        if (k == 0 .or. a == 0) then
            call file%fail_at(row, 'nothing tells of this case and algorithm above the rows or in FILE.meta.json', error)
            return
        end if
        entry = a + (k - 1)*size(campaign%algorithms)
        call parse_integer(fields(3)%text, rows%run(row), ok)
        if (ok) ok = rows%run(row) >= 1 .and. rows%run(row) <= campaign%runs
        if (.not. ok) then
            call file%fail_at(row, 'column run: a whole number from 1 to '// &
                              integer_text(campaign%runs)//' is expected', error)
            return
        end if
        call read_three(fields(4:6), rows%offset(:, row), ok)
        if (ok) ok = all(abs(rows%offset(:, row)) <= LARGEST_OFFSET)
        if (.not. ok) then
            call file%fail_at(row, 'columns dx_mm, dy_mm, dz_mm must be finite numbers from -1e9 to 1e9 mm', error)
            return
        end if
        call parse_logical(fields(7)%text, rows%converged(row), ok)
        if (.not. ok) call file%fail_at(row, 'column converged: true or false is expected', error)
        rows%normalised(row) = -1
        if (columns == RUNS_COLUMNS .or. allocated(error)) return
        call parse_real(fields(8)%text, rows%normalised(row), ok)
        if (.not. ok) call file%fail_at(row, 'column normalised: a finite number is expected', error)
    end subroutine read_row
end module gracecg_studies_campaign_files
