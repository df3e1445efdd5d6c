!> Writing Level-1 files: text as of GRACE-FO or GRACE, and binary as of GRACE.
!>
!>     call level1_layout('MAG1A', .true., layout, error)
!>     call writer%open('MAG1A_2020-02-01_C_04.txt', layout, .false., header, error)   ! header: level1_header_t
!>     call writer%record(values)                          ! by field of the layout; NaN: not in this record
!>     call writer%commit(error)
!>
!> Reals of text have the fewest of 15 to 17 digits that give the same number back: those of official files.
module gracecg_level1_writer
    use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
    use gracecg_level1_basics
    use gracecg_base_version, only: VERSION
    use gracecg_files_file, only: output_file_t
    use gracecg_level1_field_forms, only: put_bytes, BLOCK_NUMBERS, put_word
    use gracecg_level1_products, only: level1_layout_t, KIND_F4, KIND_F8, KIND_U2, FAMILIES, TITLES, is_calibration_history
    use gracecg_level1_header, only: level1_header_t, YAML_FIRST, YAML_LAST, CARDS_LAST, CARD_LENGTH, LABEL_LENGTH
    use gracecg_level1_time, only: gps_date_text
    implicit none
    private
    public :: level1_writer_t

    character(1), parameter :: LF = achar(10)
    integer, parameter :: LONGEST_RECORD = 8192     !! Characters or bytes; the longest is that of GNV1A

    type :: level1_writer_t
        !! A Level-1 file being written; it appears under its name at `commit`
        private
        type(output_file_t) :: file
        character(:), allocatable :: path
        type(level1_layout_t) :: layout
        logical :: binary = .false.
        integer(i8) :: records = 0
        integer(i8), allocatable :: rounded(:)      !! Values that lost digits in single precision, by field
        integer(i8) :: wrapped = 0                  !! Block numbers beyond the 16 bits of binary
        type(error_t), allocatable :: failure       !! The first one
    contains
        procedure :: open => open_writer        !! Begins a file with its header
        procedure :: record => write_record     !! Writes a record
        procedure :: commit => commit_writer    !! Ends the file and gives it its name
        procedure :: discard => discard_writer  !! Leaves nothing behind
        procedure :: losses                     !! What could not be kept
    end type level1_writer_t

contains

    !> Begins a file. Fails when it cannot be written, or binary is wanted of what has no binary form.
    subroutine open_writer(self, path, layout, binary, header, error)
        class(level1_writer_t), intent(inout) :: self
        character(*), intent(in) :: path                !! Of the file to write; an existing one is replaced
        type(level1_layout_t), intent(in) :: layout     !! Of the product
        logical, intent(in) :: binary                   !! Binary, not text
        type(level1_header_t), intent(in) :: header     !! Satellite, number of records, first and last time
        type(error_t), allocatable, intent(out) :: error

        if (allocated(self%failure)) deallocate (self%failure)
        self%path = trim(path)
        self%layout = layout
        self%binary = binary
        self%records = 0
        self%wrapped = 0
        self%rounded = int(0*layout%fields%kind, i8)
        if (binary .and. .not. layout%has_binary) then
            call fail(error, self%path//': '//layout%product//' of '//trim(merge('GRACE-FO', 'GRACE   ', layout%grace_fo))// &
                      ' has no binary form; it can be written as text only')
            return
        end if
        call self%file%open(path, error)
        if (allocated(error)) return
        if (binary .or. .not. layout%grace_fo .or. is_calibration_history(layout%product)) then
            call write_cards(self, header)
        else
            call write_yaml(self, header)
        end if
    end subroutine open_writer

    !> Lines of 80 characters: label and value.
    subroutine write_cards(self, header)
        class(level1_writer_t), intent(inout) :: self
        type(level1_header_t), intent(in) :: header

        integer, parameter :: CARDS = 11

        call card('PRODUCER AGENCY', 'GRACECG '//VERSION)
        call card('FILENAME', self%layout%product//'_'//date_text(header%first_time, 10)//'_'//header%satellite//'_'// &
                  merge('04', '02', self%layout%grace_fo)//merge('.dat', '.txt', self%binary))
        call card('PROCESS LEVEL (1A OR 1B)', self%layout%product(4:5))
        call card('FILE FORMAT 0=BINARY 1=ASCII', merge('0', '1', self%binary))
        call card('NUMBER OF HEADER RECORDS', integer_text(CARDS))
        call card('SATELLITE NAME', 'GRACE '//header%satellite)
        call card('TIME EPOCH (GPS TIME)', '2000-01-01 12:00:00')
        call card('TIME FIRST OBS(SEC PAST EPOCH)', time_text(header%first_time))
        call card('TIME LAST OBS(SEC PAST EPOCH)', time_text(header%last_time))
        call card('NUMBER OF DATA RECORDS', integer_text(max(0, header%records)))
        call card('SOFTWARE VERSION', 'gracecg '//VERSION)
        call self%file%bytes(CARDS_LAST//repeat(' ', CARD_LENGTH - len(CARDS_LAST))//LF)

    contains

        subroutine card(label, value)
            character(*), intent(in) :: label, value

            character(CARD_LENGTH) :: line

            line = label
            line(LABEL_LENGTH + 1:) = ': '//value
            call self%file%bytes(line//LF)
        end subroutine card
    end subroutine write_cards

    !> 738849600.007739 (2023-06-01 00:00:00.007739), with blanks behind it.
    function time_text(time) result(text)
        real(dp), intent(in) :: time            !! s past 2000-01-01 12:00 GPS
        character(60) :: text

        character(26) :: date

        date = date_text(time, len(date))
        date(11:11) = ' '
        text = trim(seconds_text(time))//' ('//date//')'
    end function time_text

    !> 738849600.007739, with blanks behind it.
    pure function seconds_text(time) result(text)
        real(dp), intent(in) :: time            !! s past 2000-01-01 12:00 GPS
        character(24) :: text

        write (text, '(f0.6)') time
        if (text(1:1) == '.') text = '0'//text
    end function seconds_text

    !> The header of GRACE-FO text.
    subroutine write_yaml(self, header)
        class(level1_writer_t), intent(inout) :: self
        type(level1_header_t), intent(in) :: header

        character(len(TITLES)) :: title
        integer :: i

        title = self%layout%product(:3)
        i = findloc(FAMILIES, self%layout%product(:3), 1)
        if (i > 0) title = TITLES(i)
        associate (file => self%file, product => self%layout%product)
            call file%line(YAML_FIRST)
            call file%line('  dimensions:')
            call file%line('    num_records: '//integer_text(max(0, header%records)))
            call file%line('  global_attributes:')
            call file%line('    creator_name: gracecg '//VERSION)
            call file%line('    platform: GRACE '//header%satellite)
            call file%line('    processing_level: '//product(4:5))
            call file%line('    product_version: 04')
            call file%line('    time_coverage_start: '//date_text(header%first_time, 22))
            call file%line('    time_coverage_stop: '//date_text(header%last_time, 22))
            call file%line('    title: GRACE-FO Level-'//product(4:5)//' '//trim(title)//' Data')
            call file%line('  non-standard_attributes:')
            call file%line('    epoch_time: 2000-01-01T12:00:00.00')
            call file%line('    software_version: '//VERSION)
            call file%line('    start_time_epoch_secs: '//trim(seconds_text(header%first_time)))
            call file%line('    stop_time_epoch_secs: '//trim(seconds_text(header%last_time)))
            call file%line('  variables:')
            do i = 1, size(self%layout%fields)
                associate (field => self%layout%fields(i))
                    if (field%channel > 1) cycle
                    call file%line('    - '//trim(field%name)//':')
                    call file%line('        comment: '//pick_text(field%bit >= 0, 'next column, if prod_flag bit set', &
                                                                  'column '//integer_text(i)))
                end associate
            end do
            call file%line(YAML_LAST)
        end associate
    end subroutine write_yaml

    !> 2023-06-01T00:00:00.007739, or so much of it.
    function date_text(time, length) result(text)
        real(dp), intent(in) :: time            !! s past 2000-01-01 12:00 GPS
        integer, intent(in) :: length           !! Characters
        character(length) :: text

        text = gps_date_text(floor(time, i8), time - floor(time, i8))
    end function date_text

    !> Writes a record. What is wrong with it is remembered and told by `commit`.
    subroutine write_record(self, values)
        class(level1_writer_t), intent(inout) :: self
        real(dp), intent(in) :: values(:)   !! By field; letters as their codes; NaN: not in this record

        character(LONGEST_RECORD) :: record
        integer :: length, i, field
        integer(i8) :: shape

        if (allocated(self%failure)) return
        self%records = self%records + 1
        length = 0
        shape = 0
        if (self%layout%shape > 0) then
            if (.not. ieee_is_nan(values(self%layout%shape))) shape = nint(values(self%layout%shape), i8)
        end if
        do i = 1, size(self%layout%fields)
            field = i
            if (self%layout%id_first .and. .not. self%binary) then
                if (i == self%layout%time_ref) field = self%layout%id
                if (i == self%layout%id) field = self%layout%time_ref
            end if
            associate (f => self%layout%fields(field), value => values(field))
                if (.not. f%in_records_of(shape)) cycle
                if (ieee_is_nan(value) .and. f%kind /= KIND_F4 .and. f%kind /= KIND_F8) then
                    call fail(self%failure, self%path//': record '//integer_text(self%records)//' has no '//trim(f%name))
                    return
                else if (self%binary) then
                    call write_bytes(self, value, field, record, length)
                    if (allocated(self%failure)) return
                else
                    call put_word(value, f%kind, record, length)
                end if
            end associate
        end do
        if (.not. self%binary) record(length:length) = LF
        call self%file%bytes(record(:length))
    end subroutine write_record

    !> Puts a value behind the bytes of a record and counts what it loses.
    subroutine write_bytes(self, value, field, record, length)
        class(level1_writer_t), intent(inout) :: self
        real(dp), intent(in) :: value
        integer, intent(in) :: field
        character(*), intent(inout) :: record
        integer, intent(inout) :: length

        logical :: is_rounded, is_too_large

        associate (f => self%layout%fields(field))
            call put_bytes(value, f, record, length, is_rounded, is_too_large)
            if (is_too_large) call fail(self%failure, self%path//': record '//integer_text(self%records)//', '// &
                                        trim(f%name)//': '//real_text(value)// &
                                        ' is too large for single precision, which binary has')
            if (is_rounded) self%rounded(field) = self%rounded(field) + 1
            if (f%kind == KIND_U2 .and. value >= BLOCK_NUMBERS) self%wrapped = self%wrapped + 1
        end associate
    end subroutine write_bytes

    !> Ends the file and gives it its name. After a failure there is no file, or still an older one.
    subroutine commit_writer(self, error)
        class(level1_writer_t), intent(inout) :: self
        type(error_t), allocatable, intent(out) :: error

        if (allocated(self%failure)) then
            call move_alloc(self%failure, error)
            call self%file%discard()
        else
            call self%file%commit(error)
        end if
    end subroutine commit_writer

    !> Gives the file up: nothing of it is left.
    subroutine discard_writer(self)
        class(level1_writer_t), intent(inout) :: self

        call self%file%discard()
    end subroutine discard_writer

    !> What of the records the form of the file could not keep: a sentence each; none: all was kept.
    function losses(self) result(texts)
        class(level1_writer_t), intent(in) :: self
        type(string_t), allocatable :: texts(:)

        integer :: i

        allocate (texts(0))
        do i = 1, size(self%rounded)
            if (self%rounded(i) > 0) &
                call append(texts, integer_text(self%rounded(i))//' values of '//trim(self%layout%fields(i)%name)// &
                            ' were rounded to the single precision that binary has')
        end do
        if (self%wrapped > 0) &
            call append(texts, integer_text(self%wrapped)//' block numbers are beyond the 16 bits of binary: they begin '// &
                        'anew at '//integer_text(BLOCK_NUMBERS))
    end function losses
end module gracecg_level1_writer
