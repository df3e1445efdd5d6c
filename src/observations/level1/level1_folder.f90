!> The Level-1 files of a folder, by product and satellite, as their names say.
module gracecg_observations_level1_folder
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_text, only: string_t, append
    use gracecg_files_folder, only: files_in_folder
    use gracecg_observations_level1_header, only: product_of_file_name, satellite_of_file_name, date_of_file_name
    use gracecg_observations_level1_products, only: SATELLITES
    implicit none
    private
    public :: level1_folder_t, open_level1_folder

    type :: level1_folder_t
        !! The files of one satellite and one day, and the calibration histories
        character(:), allocatable :: folder    !! As the user gave it
        character(1) :: satellite = ''                  !! A to D
        character(10) :: date = ''                      !! YYYY-MM-DD of the names
        type(string_t), allocatable :: paths(:)         !! Of all files of the satellite, by name
        type(string_t), allocatable :: warnings(:)      !! What was passed over
    contains
        procedure :: path_of                            !! The file of a product
    end type level1_folder_t

    !> Products whose files stand for long times: their dates are not that of the data
    character(5), parameter :: HISTORIES(10) = ['QSA1B', 'QKS1B', 'QSB1B', 'QCP1B', 'VCM1B', 'VKB1B', 'VGN1B', 'VGB1B', &
                                                'VGO1B', 'VSL1B']

contains

    !> Looks what is there. Without a satellite it is the first one that has files, and the day the first that it
    !> has files of. Fails when there is no Level-1 file of it.
    subroutine open_level1_folder(folder, satellite, files, error)
        character(*), intent(in) :: folder              !! With or without a slash at the end
        character(1), intent(in) :: satellite           !! A to D; blank: the first one
        type(level1_folder_t), intent(out) :: files
        type(error_t), allocatable, intent(out) :: error

        type(string_t), allocatable :: found(:)
        character(:), allocatable :: others, dates
        character(1) :: letter
        integer :: i

        files%folder = trim(folder)
        allocate (files%paths(0), files%warnings(0))
        call files_in_folder(folder, found, error)
        if (allocated(error)) return
        files%satellite = satellite
        others = ''
        do i = 1, size(found)
            letter = satellite_of_file_name(found(i)%text)
            if (product_of_file_name(found(i)%text) == '' .or. scan(letter, SATELLITES) == 0) cycle
            if (is_history(found(i)%text)) cycle
            if (files%satellite == '') files%satellite = letter
            if (letter /= files%satellite .and. index(others, letter) == 0) others = others//' '//letter
        end do
        dates = ''
        do i = 1, size(found)
            if (product_of_file_name(found(i)%text) == '') cycle
            if (satellite_of_file_name(found(i)%text) /= files%satellite) cycle
            if (.not. is_history(found(i)%text)) then
                if (files%date == '') files%date = date_of_file_name(found(i)%text)
                if (date_of_file_name(found(i)%text) < files%date) files%date = date_of_file_name(found(i)%text)
                if (index(dates, date_of_file_name(found(i)%text)) == 0) dates = dates//' '//date_of_file_name(found(i)%text)
            end if
            call append(files%paths, found(i)%text)
        end do
        if (files%date == '') then
            others = ''
            if (satellite /= '') others = ' of satellite '//satellite
            call fail(error, trim(folder)//': no Level-1 files'//others//'; their names are like '// &
                      'ACC1A_2023-06-01_C_04.txt')
            return
        end if
        if (others /= '' .and. satellite == '') &
            call append(files%warnings, 'the folder has files of satellites '//files%satellite//others//': '// &
                        files%satellite//' is taken')
        if (len_trim(dates) > len(files%date) + 1) &
            call append(files%warnings, 'the folder has files of several days,'//dates//': '//files%date//' is taken')
    end subroutine open_level1_folder

    pure logical function is_history(path)
        character(*), intent(in) :: path

        is_history = any(HISTORIES == product_of_file_name(path))
    end function is_history

    !> The file of a product: of that day, text before binary (by name the last); of a history the last one of all.
    !> Empty when there is none.
    subroutine path_of(self, product, path)
        class(level1_folder_t), intent(in) :: self
        character(5), intent(in) :: product         !! 'ACC1A'
        character(:), allocatable, intent(out) :: path    !! Empty when there is none

        integer :: i

        path = ''
        do i = 1, size(self%paths)
            if (product_of_file_name(self%paths(i)%text) /= product) cycle
            if (date_of_file_name(self%paths(i)%text) /= self%date .and. .not. is_history(self%paths(i)%text)) cycle
            path = self%paths(i)%text
        end do
    end subroutine path_of
end module gracecg_observations_level1_folder
