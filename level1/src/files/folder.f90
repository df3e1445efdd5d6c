!> The Level-1 files of some places, by product, satellite and day, as their names say.
module gracecg_level1_folder
    use gracecg_level1_basics
    use gracecg_base_text, only: join
    use gracecg_environment_time, only: parse_utc
    use gracecg_files_file, only: is_unfinished
    use gracecg_level1_bundles, only: find_level1_files
    use gracecg_level1_header, only: product_of_file_name, satellite_of_file_name, date_of_file_name, name_of
    use gracecg_level1_products, only: SATELLITES, is_calibration_history
    implicit none
    private
    public :: level1_folder_t, open_level1_folder

    integer, parameter :: RELEASE_AT = 21       !! Where the release stands in a name: 04 of ACC1A_2023-06-01_C_04.txt

    type :: level1_folder_t
        !! The files of one satellite, of one day or several, and the calibration histories
        character(:), allocatable :: places    !! As the user gave them
        character(1) :: satellite = ''                  !! A to D
        character(10) :: date = ''                      !! YYYY-MM-DD of the names: the first day, or the one asked for
        character(10), allocatable :: days(:)           !! All days that are joined, in order
        type(string_t), allocatable :: paths(:)         !! Of all files of the satellite: of each product and day the newest
                                                        !! release, and text where there is text and binary
        type(string_t), allocatable :: events(:)        !! Paths of SOE files
        type(string_t), allocatable :: warnings(:)      !! What was passed over
    contains
        procedure :: paths_of                           !! The files of a product on all days
        procedure :: days_with                          !! On how many days a product is there
    end type level1_folder_t

contains

    !> Looks what is there. Without a satellite it is the first one that has files. All days that it has files of belong
    !> together; with a day that one, the one before and the one behind, for a manoeuvre may begin or end there. Fails when
    !> there is no Level-1 file of the satellite, or of that day.
    subroutine open_level1_folder(places, satellite, files, error, day)
        character(*), intent(in) :: places(:)           !! Folders with all that is in them, bundles, files
        character(*), intent(in) :: satellite           !! A to D; blank: the first one
        type(level1_folder_t), intent(out) :: files
        type(error_t), allocatable, intent(out) :: error
        character(*), intent(in), optional :: day       !! YYYY-MM-DD; blank: all

        type(string_t), allocatable :: found(:)
        character(:), allocatable :: others
        character(10) :: wanted, date
        character(5) :: product
        character(1) :: letter
        integer :: i, number, earlier

        files%places = join(places, ', ')
        allocate (files%paths(0), files%warnings(0), files%days(0), files%events(0), found(0))
        wanted = ''
        if (present(day)) wanted = day
        number = day_number(wanted)
        if (wanted /= '') then
            if (number == 0 .or. len_trim(day) /= len(wanted)) then
                call fail(error, '"'//trim(day)//'" is no date; a day is given like 2020-02-01')
                return
            end if
        end if
        do i = 1, size(places)
            call find_level1_files(trim(places(i)), found, error)
            if (allocated(error)) return
        end do
        files%satellite = satellite
        others = ''
        do i = 1, size(found)
            product = product_of_file_name(found(i)%text)
            letter = satellite_of_file_name(found(i)%text)
            if (product == '') cycle
            if (is_unfinished(found(i)%text)) then
                call append(files%warnings, found(i)%text//' is left out: it is what is left of a program that was ended '// &
                            'while it wrote')
                found(i)%text = ''
                cycle
            end if
            if (is_calibration_history(product) .or. scan(letter, SATELLITES) == 0) cycle
            if (files%satellite == '') files%satellite = letter
            if (letter /= files%satellite .and. index(others, letter) == 0) others = others//' '//letter
        end do
        do i = 1, size(found)
            product = product_of_file_name(found(i)%text)
            if (is_soe(found(i)%text)) call append(files%events, found(i)%text)
            if (product == '' .or. satellite_of_file_name(found(i)%text) /= files%satellite) cycle
            if (.not. is_calibration_history(product)) then
                date = date_of_file_name(found(i)%text)
                if (number /= 0 .and. abs(day_number(date) - number) > 1) cycle
                if (all(files%days /= date)) then
                    earlier = count(files%days < date)
                    files%days = [files%days(:earlier), date, files%days(earlier + 1:)]
                end if
            end if
            call append(files%paths, found(i)%text)
        end do
        if (size(files%days) > 0) files%date = files%days(1)
        if (wanted /= '' .and. any(files%days == wanted)) files%date = wanted
        if (size(files%days) == 0 .or. (wanted /= '' .and. files%date /= wanted)) then
            others = ''
            if (satellite /= '') others = ' of satellite '//satellite
            if (wanted /= '') others = others//' of '//wanted
            call fail(error, files%places//': no Level-1 files'//others//'; their names are like '// &
                      'ACC1A_2023-06-01_C_04.txt')
            return
        end if
        if (others /= '' .and. satellite == '') &
            call append(files%warnings, 'there are files of satellites '//files%satellite//others//': '// &
                        files%satellite//' is taken')
        call keep_newest(files)
        call tell_days(files)
    end subroutine open_level1_folder

    !> That days are joined, and whether days between them are missing.
    subroutine tell_days(files)
        type(level1_folder_t), intent(inout) :: files

        character(:), allocatable :: text
        integer :: n, missing

        n = size(files%days)
        if (n < 2) return
        text = 'files of '//integer_text(n)//' days are joined, '//files%days(1)//' to '//files%days(n)
        missing = day_number(files%days(n)) - day_number(files%days(1)) + 1 - n
        if (missing > 0) text = text//' ('//integer_text(missing)//' between are missing)'
        call append(files%warnings, text)
    end subroutine tell_days

    !> The modified Julian day of a date YYYY-MM-DD; 0 when it is none.
    integer function day_number(date) result(number)
        character(10), intent(in) :: date

        type(utc_t) :: utc
        type(error_t), allocatable :: error

        call parse_utc(date, utc, error)
        number = merge(0, utc%mjd, allocated(error))
    end function day_number

    !> Leaves out what stands there in a newer release, and binary files of what stands there as text.
    subroutine keep_newest(files)
        type(level1_folder_t), intent(inout) :: files

        integer, parameter :: STEM = 19     ! ACC1A_2023-06-01_C: what tells one file from all others but its releases
        character(80) :: names(size(files%paths))
        character(2) :: release(size(names))
        logical :: stays(size(names)), binary(size(names)), alike(size(names))
        type(string_t), allocatable :: kept(:)
        character(:), allocatable :: newer
        integer :: i, left_out

        names = [character(80) :: (name_of(files%paths(i)%text), i=1, size(names))]
        release = names(:)(RELEASE_AT:RELEASE_AT + 1)
        binary = [(is_binary(names(i)), i=1, size(names))]
        left_out = 0
        do i = 1, size(names)
            alike = names(:)(:STEM) == names(i)(:STEM)
            stays(i) = .not. any(alike .and. (release > release(i) .or. (release == release(i) .and. binary(i) .and. .not. binary)))
            if (.not. any(alike .and. release > release(i))) cycle
            left_out = left_out + 1
            if (left_out == 1) newer = trim(names(i))//' has the newer release '// &
                trim(names(findloc(alike .and. release == maxval(release, mask=alike), .true., 1)))
        end do
        if (left_out == 1) call append(files%warnings, newer//', which is taken')
        if (left_out > 1) call append(files%warnings, newer//', which is taken; so it is with '//integer_text(left_out - 1)// &
                                      ' other files')
        allocate (kept(0))
        do i = 1, size(stays)
            if (stays(i)) call append(kept, files%paths(i)%text)
        end do
        call move_alloc(kept, files%paths)
    end subroutine keep_newest

    !> Whether a name is that of a binary file.
    pure logical function is_binary(name)
        character(*), intent(in) :: name

        is_binary = index(lower_case(name), '.dat') > 0 .or. index(lower_case(name), '.bin') > 0
    end function is_binary

    !> Whether a path is that of an SOE file.
    pure logical function is_soe(path)
        character(*), intent(in) :: path

        character(:), allocatable :: name

        name = lower_case(name_of(path))
        is_soe = index(name, 'soe') == 1 .or. index(name, 'tn-01') == 1 .or. index(name, 'tn01') == 1 .or. index(name, '_soe') > 0
    end function is_soe

    !> The files of a product on all days, in order; of a history those of the last day that has one. None where there is none.
    subroutine paths_of(self, product, paths)
        class(level1_folder_t), intent(in) :: self
        character(5), intent(in) :: product         !! 'ACC1A'
        type(string_t), allocatable, intent(out) :: paths(:)    !! Usually one of each day; more: parts, or copies

        character(10) :: dates(size(self%paths))        ! of the product's files; blank: of another product
        character(10), allocatable :: days(:)
        integer :: i, day

        allocate (paths(0))
        dates = ''
        do i = 1, size(self%paths)
            if (product_of_file_name(self%paths(i)%text) == product) dates(i) = date_of_file_name(self%paths(i)%text)
        end do
        days = self%days
        if (is_calibration_history(product)) days = [maxval(dates)]
        do day = 1, size(days)
            do i = 1, size(self%paths)
                if (dates(i) == days(day) .and. dates(i) /= '') call append(paths, self%paths(i)%text)
            end do
        end do
    end subroutine paths_of

    !> On how many days there are files of a product.
    pure integer function days_with(self, product)
        class(level1_folder_t), intent(in) :: self
        character(5), intent(in) :: product         !! 'ACC1A'

        integer :: i, day

        days_with = 0
        do day = 1, size(self%days)
            if (any([(product_of_file_name(self%paths(i)%text) == product .and. &
                      date_of_file_name(self%paths(i)%text) == self%days(day), i=1, size(self%paths))])) days_with = days_with + 1
        end do
    end function days_with
end module gracecg_level1_folder
